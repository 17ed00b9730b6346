"""A trained mind drives a body that `metal serve` plays, and the studio watches."""

import subprocess

from .page import Server, expect

# A mind with next to no training, enough to drive a body.
DRIVER = """
title = "A driver for tests"
[environment.highway_scripted]
horizon = 10
[learner.tiny.mlp]
[member.MN]
sensors = ["MN"]
learner = "tiny"
[member.IR]
sensors = ["IR"]
learner = "tiny"
[phase.demonstration]
roster = ["MN", "IR"]
acting = "advisor"
sensing = "everyone"
rate = "full"
budget = { steps = 60 }
[policy.oracle]
acting = "advisor"
[policy.blind]
acting = "blind"
[policy.near]
after = "demonstration"
roster = ["MN"]
acting = { solo = "MN" }
[evaluation]
runs = 1
"""


def watch_body(page, server, program, scratch):
    """A trained mind drives a body that `metal serve` plays: it stands, goes, is held, and is stopped by one key."""
    (scratch / "driver.toml").write_text(DRIVER)
    subprocess.run([*program, "run", str(scratch / "driver.toml"), "--out", str(scratch / "driver"), "--seeds", "1"],
                   check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    decisions = 0
    for body, more in (("webots", ["--road-seed", "1"]), ("epuck2", [])):
        played = subprocess.Popen([*program, "serve", body, "--bind", "127.0.0.1:0"], stdout=subprocess.PIPE, text=True)
        try:
            address = played.stdout.readline().strip().removeprefix("listening at ")
            arguments = ["--run", str(scratch / "driver"), "--robot", f"{body}://{address}", *more]
            studio = Server(program, None, extra=arguments)
            try:
                decisions += drive_body(page, studio, bool(more))
            finally:
                studio.end()
        finally:
            played.kill()
            played.wait(20)
    return decisions


def drive_body(page, studio, supervised):
    page.browser.call("Page.navigate", url=studio.url)
    page.until("window.studio?.stats.frames > 0 && document.body.dataset.view === 'body'", "the body is on the stage")
    expect(page.ask("document.querySelector('#run .word').textContent") == "Run", "it stands until somebody lets it go")
    expect(page.text("facts").startswith("would"), "what it would do is shown")
    hidden = page.ask("[...document.querySelectorAll('.no-body')].every(e => !e.getClientRects().length)")
    expect(hidden, "nobody can steer it from the page")
    page.ask("studio.ask('place', {body: 0, x: 0, y: 0})")
    page.until("document.getElementById('notice').textContent.includes('only watched')", "not even by hand")
    page.click("#run")
    page.until("studio.stats.frames >= 6", "it drives", 30)
    expect("link" in page.text("facts"), "what a step costs on the link is shown")
    expect(page.ask("studio.where(0) !== null") == supervised, "from above, if somebody knows where it is")
    page.click("#run")
    page.until("document.querySelector('#run .word').textContent === 'Run'", "it is held")
    page.ask("document.activeElement.blur()")
    page.key("Escape")
    page.until("document.getElementById('brake').disabled", "and stopped for good by one key")
    page.key(".")
    page.until("document.getElementById('notice').textContent.includes('emergency stop')", "nothing moves it any more")
    return page.ask("studio.stats.frames")
