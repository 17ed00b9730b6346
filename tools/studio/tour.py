"""What a person does in the studio."""

import json
import signal
import time

from .page import Server, expect

STEPS = 30
# Steps of a whole demonstration, as in the paper.
WANTED = 200
UNDOABLE = 20
# What is done instead of the steps that were taken back.
AGAIN = [0, 3, 4, 1, 2] * (UNDOABLE // 5)
BY_KEY = {0: "ArrowUp", 1: "m", 2: "s", 3: "ArrowRight", 4: "ArrowLeft"}
DECISIONS = 100


def demonstrate(page, folder):
    """Thirty steps with keys, twenty taken back and made again with keys, finger, gamepad: the record is on disk."""
    page.click("#demonstrate")
    page.until("document.getElementById('demonstrate').textContent.startsWith('Leave')", "the wheel is taken")
    page.ask("document.activeElement.blur()")
    keys = ["ArrowUp", "m", "s", "ArrowLeft", "ArrowRight"]
    shown = "Number(document.querySelector('#ring text').textContent)"
    for step in range(STEPS):
        page.key(keys[step % len(keys)])
        page.until(f"{shown} === {step + 1}", f"step {step + 1} is shown", 10)
    for step in range(UNDOABLE):
        page.key("u")
        page.until(f"{shown} === {STEPS - 1 - step}", f"step {STEPS - step} is taken back")
    expect(page.ask("document.getElementById('undo').disabled"), "no more than twenty can be taken back")
    again(page, shown)
    expect("unlike the expert" in page.text("quality"), "quality is shown")
    page.click("#save")
    page.until("document.getElementById('saved').textContent.includes('0001.jsonl')", "the demonstration is saved")
    lines = (folder / "demonstrations/0001.jsonl").read_text().splitlines()
    header, rows = json.loads(lines[0]), [json.loads(line) for line in lines[1:]]
    acted = [row["action"] for row in rows if row.get("action") is not None]
    expect(header["environment"] == "Highway-v0" and len(header["sensors"]) == 7, "the record's header")
    wanted = [[0, 1, 2, 4, 3][i % 5] for i in range(STEPS - UNDOABLE)] + AGAIN
    expect(acted == wanted, f"the record holds the keys that were pressed: {acted}")
    page.click("#demonstrate")
    page.until("document.getElementById('demonstrate').textContent.startsWith('Take')", "the wheel is left")


def autosave(page, folder):
    """At the paper's 200 steps the set is saved by itself, and the clock stands."""
    page.click("#demonstrate")
    page.until("document.getElementById('demonstrate').textContent.startsWith('Leave')", "the wheel is taken")
    page.ask("document.activeElement.blur()")
    page.choose("speed", "0")
    page.click("#run")
    page.until("document.getElementById('saved').textContent.includes('0002.jsonl')", "two hundred steps are saved", 60)
    page.until("document.querySelector('#run .word').textContent === 'Run'", "the clock stands")
    rows = [json.loads(line) for line in (folder / "demonstrations/0002.jsonl").read_text().splitlines()[1:]]
    expect(sum(row.get("action") is not None for row in rows) == WANTED, "two hundred steps, no more and no fewer")
    page.click("#demonstrate")
    page.until("document.getElementById('demonstrate').textContent.startsWith('Take')", "the wheel is left")


def again(page, shown):
    """The steps that were taken back, by finger, by gamepad, by keys."""
    ways = [lambda a: page.touch(f"#pad [data-at='{a}']"), lambda a: gamepad(page, a), lambda a: page.key(BY_KEY[a])]
    page.browser.call("Emulation.setTouchEmulationEnabled", enabled=True)
    page.ask("document.getElementById('pad').scrollIntoView({block: 'center'})")
    for made, action in enumerate(AGAIN):
        ways[made % 3](action)
        page.until(f"{shown} === {STEPS - UNDOABLE + made + 1}", f"step {made + 1} is made again", 10)
    page.browser.call("Emulation.setTouchEmulationEnabled", enabled=False)
    page.ask("delete navigator.getGamepads")


def gamepad(page, action):
    """A gamepad of which one button is pressed for a moment, or the stick is moved."""
    button, stick = {0: (0, 0), 1: (2, 0), 2: (1, 0), 3: (-1, 1), 4: (-1, -1)}[action]
    page.ask(f"navigator.getGamepads = () => [{{axes: [{stick}, 0], buttons: [...Array(16)].map((_, i) => ({{pressed: i === {button}}}))}}]")
    page.until(f"document.querySelector(`#pad [data-at='{action}']`).classList.contains('down')", "the gamepad is read", 5)
    page.ask("navigator.getGamepads = () => [{axes: [0, 0], buttons: [...Array(16)].map(() => ({pressed: false}))}]")
    page.until("!document.querySelector('#pad .down')", "and let go", 5)


def explore(page):
    """A situation of Table 1, a dragged car, a broken sensor, two drivers side by side."""
    page.click("#scenes li:nth-child(4) button")
    page.until("document.querySelector('#scenes li:nth-child(4) button').getAttribute('aria-pressed') === 'true'",
               "the situation is open")
    expect("paper MN MF IR" in page.text("scenes"), "the paper's looks stand beside ours")
    expect(page.ask("document.querySelectorAll('#scenes button').length") == 6, "all six situations")
    for fault in ("blind", "noisy", "off", "fine"):
        page.ask(f"(s => {{ s.value = '{fault}'; s.dispatchEvent(new Event('change')); }})(document.querySelector('#faults select'))")
        page.until(f"document.querySelector('#faults label').classList.contains('broken') === {str(fault != 'fine').lower()}",
                   f"the sensor is {fault}")
    box = page.ask("(b => [b.x, b.y, b.width, b.height])(document.querySelector('.lane canvas').getBoundingClientRect())")
    before = page.ask("document.getElementById('facts').textContent")
    expect(before.startswith("would"), "a situation is looked at, not driven on")
    page.ask("document.querySelector('.lane canvas').focus()")
    for _ in range(3):
        page.browser.call("Input.dispatchKeyEvent", type="keyDown", key="ArrowUp", windowsVirtualKeyCode=38, modifiers=8)
    page.until("document.querySelector('#scenes [aria-pressed=true]') === null", "the car was moved by keys")
    expect(box[2] > 200 and box[3] > 200, "the road has room")
    page.ask("scrollTo(0, 0)")
    for body in (0, 1):
        start = page.ask(f"studio.where({body})")
        end = [start[0] - 40, start[1] + 25]
        page.drag(start, end)
        page.until(f"(p => Math.hypot(p[0] - {end[0]}, p[1] - {end[1]}) < 4)(studio.where({body}))", f"car {body} was dragged")


def pace(page):
    """What reaches the page each second while it watches a run, and how often the browser draws."""
    return page.ask("""new Promise(done => { const from = {...studio.stats}, start = performance.now(); let drawn = 0;
      const count = () => { drawn += 1; const secs = (performance.now() - start) / 1000;
        if (secs < 3) requestAnimationFrame(count);
        else done([(studio.stats.frames - from.frames) / secs, (studio.stats.bytes - from.bytes) / secs / 1000, drawn / secs]); };
      requestAnimationFrame(count); })""")


def speeds(page):
    """Every speed can be chosen, and decisions come as fast as it says: two a second at speed 1."""
    for value in ("0", "0.25", "1", "4", "8"):
        page.choose("speed", value)
        page.until(f"studio.status().times === {value}", f"speed {value}")
    rates = {}
    for value in ("0.5", "2", "16"):
        page.choose("speed", value)
        page.until(f"studio.status().times === {value}", f"speed {value}")
        rates[value] = page.ask(
            """new Promise(done => { const from = studio.frame().n, start = performance.now();
              setTimeout(() => done(1000 * (studio.frame().n - from) / (performance.now() - start)), SECONDS * 1000); })"""
            .replace("SECONDS", "2.5" if value == "0.5" else "1.2"))
    expect(0.3 < rates["0.5"] < 2 and 2 < rates["2"] < 6.5 and rates["16"] > 12, f"decisions a second by speed: {rates}")


def timeline(page):
    """Pause, scrub back, see an older decision, and come back."""
    page.ask("document.activeElement.blur()")
    page.choose("driver", "0")
    if page.ask("document.querySelector('#run .word').textContent === 'Run'"):
        page.click("#run")
    speeds(page)
    last = page.ask("Number(document.getElementById('scrub').value)")
    page.until(f"Number(document.getElementById('scrub').value) > {last} + 20", "decisions are made")
    page.click("#run")
    page.until("document.querySelector('#run .word').textContent === 'Run'", "the clock stands")
    time.sleep(0.8)
    page.until("document.querySelectorAll('#timeline rect').length > 60", "the timeline is drawn")
    page.ask("(s => { s.value = Number(s.value) - 15; s.dispatchEvent(new Event('input')); })(document.getElementById('scrub'))")
    page.until("document.getElementById('where').textContent.startsWith('decision')", "an older decision is shown")
    page.click("#now")
    page.until("document.getElementById('now').hidden", "and now again")
    page.click("#scrub")
    page.until("document.getElementById('where').textContent.startsWith('decision')", "a click shows the decision there")
    expect(page.ask("studio.frame().n < Number(document.getElementById('scrub').max)"), "an older one")
    page.click("#now")
    page.until("document.getElementById('now').hidden", "and now once more")
    step = page.text("facts")
    page.key(".")
    page.until(f"document.getElementById('facts').textContent !== {step!r}", "a single step")


def compare(page):
    """Two drivers on the same road, from the same place, with the same traffic, which then meets different ones."""
    page.choose("rival", "1")
    page.until("document.querySelectorAll('.lane canvas').length === 2", "two lanes")
    page.choose("scenario", page.ask("[...document.getElementById('scenario').options].at(-1).value"))
    page.click("#reset")
    # Until the new scenario's frame is there, that of the old one stands, also at step 0: but nobody else is on its road.
    page.until("studio.frame().lanes.length === 2 && studio.frame().step === 0"
               " && studio.frame().lanes.every(lane => lane.from.length > 1)", "both begin anew, with a car")
    both = page.ask("studio.frame().lanes.map(lane => [lane.road, lane.from])")
    expect(both[0] == both[1], f"the same beginning for both: {both}")
    names = page.ask("studio.frame().lanes.map(lane => lane.driver)")
    expect(names[0] != names[1], f"two drivers: {names}")
    page.choose("rival", "")
    page.until("document.querySelectorAll('.lane canvas').length === 1", "one lane")


def train(page):
    """Watch a run for a hundred decisions; hold it, let it go on; see curves that the studio drew."""
    page.click("#tab-curves")
    page.click("#train")
    page.until("document.getElementById('training-note').textContent.startsWith('running')", "the run learns")
    page.until("/fusion|attention/.test(document.getElementById('training-note').textContent)", "phase II", 60)
    page.click("#tab-stage")
    start, drops = page.ask("[studio.stats.frames, studio.stats.drops]")
    page.until(f"studio.stats.frames >= {start} + {DECISIONS}", f"{DECISIONS} decisions of a run are watched", 60)
    expect(page.ask("studio.stats.drops") == drops, "without a dropped connection")
    expect("learning" in page.ask("document.querySelector('.lane .name').textContent"), "the stage shows the run")
    told = pace(page)
    page.click("#tab-curves")
    page.click("#hold")
    page.until("document.getElementById('training-note').textContent.startsWith('paused')", "the run is held")
    page.until("document.querySelectorAll('#charts svg.chart').length >= 5", "curves are drawn")
    page.click("#hold")
    page.until("document.getElementById('training-note').textContent.startsWith('running')", "the run goes on")
    return told


def stop_training(page):
    page.click("#stop")
    page.until("document.getElementById('training-note').textContent.startsWith('stopped')", "the run is stopped")
    page.click("#tab-stage")


def keep(page):
    """The stage as SVG and PNG."""
    for button, name in (("svg", "metal-stage.svg"), ("png", "metal-stage.png")):
        page.click(f"#{button}")
        page.until(f"studio.kept?.name === {name!r} && studio.kept.bytes > 2000", f"{name} is kept")


def lose_and_find(page, server, program, folder):
    """The server dies and comes back at the same address: the page says so, and recovers."""
    server.end(signal.SIGKILL)
    page.until("!document.getElementById('lost').hidden", "the page says that the connection is lost")
    expect("retrying" in page.text("lost"), "and that it tries again")
    again = Server(program, folder, port=server.port)
    expect(again.url == server.url, "the address is the same")
    page.until("document.getElementById('lost').hidden", "the page found the studio again", 30)
    page.until("document.querySelector('#connection').dataset.state === 'live'", "and is live")
    return again
