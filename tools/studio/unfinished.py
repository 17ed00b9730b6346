"""A run that was killed can be watched as far as it came."""

import subprocess
import time

from .body import DRIVER
from .page import Server, expect

# A phase that is saved often and does not end by itself before it is killed.
LONG = """
[attention.acl]
learner = "tiny"
[phase.attention]
after = "demonstration"
roster = ["MN", "IR"]
acting = { attention = "acl" }
rate = "full"
budget = { steps = 50000000 }
[policy.acl]
after = "attention"
roster = ["MN", "IR"]
acting = { attention = "acl" }
"""


def watch_unfinished(page, program, scratch):
    """Kills a run in the middle of a phase and opens its folder: finished and unfinished minds drive."""
    plan, folder = scratch / "unfinished.toml", scratch / "unfinished"
    plan.write_text(DRIVER + LONG)
    run = subprocess.Popen([*program, "run", str(plan), "--out", str(folder), "--seeds", "1", "--save-every", "1"],
                           stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    end = time.monotonic() + 60
    try:
        while not list(folder.glob("checkpoint/*draft*.piece")):
            expect(run.poll() is None and time.monotonic() < end, "a phase on its way is saved")
            time.sleep(0.1)
    finally:
        # `cargo run` would leave its child behind, so the program itself is what is killed.
        subprocess.run(["pkill", "-KILL", "-f", str(plan)], check=False)
        run.wait(20)
    server = Server(program, None, extra=["--run", str(folder)])
    try:
        page.browser.call("Page.navigate", url=server.url)
        page.until("window.studio?.stats.frames > 0", "the stage of an unfinished run")
        drivers = page.ask("[...document.getElementById('driver').options].map(o => o.text)")
        wanted = ("(checkpoint)", "(checkpoint, still learning)")
        expect(all(any(name.endswith(end) for name in drivers) for end in wanted), f"both minds are there: {drivers}")
        for ending in wanted:
            page.choose("driver", next(str(i) for i, name in enumerate(drivers) if name.endswith(ending)))
            page.until(f"studio.frame().lanes[0].driver.endsWith({ending!r})", f"a mind of the {ending} drives")
    finally:
        server.end()
