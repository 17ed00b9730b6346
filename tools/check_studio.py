#!/usr/bin/env python3
"""Drives `metal studio` in headless Chromium with real keys, then attacks it.

    check_studio.py [--metal PROGRAM] [--screenshots DIR]

The first part is a person: demonstrates thirty steps, finds them on disk, watches a run train, scrubs back, opens a
situation of Table 1, drags a car, breaks a sensor, compares two drivers, loses the server and gets it back. The second
part is an attacker without the token, with a foreign name, with a foreign page. Needs only Chromium: it speaks the
DevTools protocol over a pipe, as check_report.py does. With --screenshots it only takes the pictures of the guide.
"""

import argparse
import base64
import json
import pathlib
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time

from check_report import Browser, complaints_of_console

SECONDS = 170
PICTURE_SECONDS = 500
# Enough for a mind that is worth a picture.
PICTURE_BUDGETS = ["phase.fusion.budget.episodes=300", "phase.attention.budget.episodes=900"]
STEPS = 30
UNDOABLE = 20
# What is done instead of the steps that were taken back.
AGAIN = [0, 3, 4, 1, 2] * (UNDOABLE // 5)
BY_KEY = {0: "ArrowUp", 1: "m", 2: "s", 3: "ArrowRight", 4: "ArrowLeft"}
DECISIONS = 100
LEAST_CONTRAST = 4.5
KEYS = {"Tab": 9, "Escape": 27, "ArrowUp": 38, "ArrowRight": 39, "ArrowLeft": 37, "m": 77, "s": 83, "u": 85, ".": 190}

# Texts that are too pale for the page they stand on, by WCAG's formula.
PALE = """(() => {
  const rgb = text => (text.match(/[0-9.]+/g) || []).map(Number);
  const light = c => c.slice(0, 3).map(v => v / 255).map(v => v <= 0.03928 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4)
    .reduce((sum, v, i) => sum + v * [0.2126, 0.7152, 0.0722][i], 0);
  const ground = e => { for (; e; e = e.parentElement) { const c = rgb(getComputedStyle(e).backgroundColor);
    if (c.length === 3 || c[3] > 0.5) return c; } return [255, 255, 255]; };
  const pale = [];
  // A number in the decision space stands on its bar.
  const over = e => { const bar = e.closest('td')?.querySelector('i'), below = ground(e); if (!bar) return below;
    const [c, share] = [rgb(getComputedStyle(bar).backgroundColor), Number(getComputedStyle(bar).opacity)];
    return below.slice(0, 3).map((v, i) => share * c[i] + (1 - share) * v); };
  const judge = (e, front, back, least, words) => { const [a, b] = [light(front), light(back)];
    const contrast = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
    if (contrast < least) pale.push(`${contrast.toFixed(1)} ${e.tagName} ${words}`); };
  for (const e of document.querySelectorAll('main:not([hidden]) *, header *, footer *')) {
    const own = [...e.childNodes].some(n => n.nodeType === 3 && n.textContent.trim());
    const style = getComputedStyle(e);
    if (own && !e.closest('canvas, :disabled, .hidden, title') && e.getClientRects().length)
      judge(e, rgb(e.closest('svg') ? style.fill : style.color), over(e), LEAST, e.textContent.trim().slice(0, 30));
    // The edge of what can be operated is as important as a text is.
    if (e.matches('button, select') && !e.disabled && e.getClientRects().length && parseFloat(style.borderTopWidth) > 0 && rgb(style.borderTopColor)[3] !== 0)
      judge(e, rgb(style.borderTopColor), ground(e.parentElement), 3, 'edge');
  }
  return [...new Set(pale)].slice(0, 8);
})()""".replace("LEAST", str(LEAST_CONTRAST))

# Controls that nobody can name who cannot see them.
NAMELESS = """[...document.querySelectorAll('button, select, input, canvas')].filter(e => e.getClientRects().length)
  .filter(e => !(e.textContent.trim() || e.getAttribute('aria-label') || e.labels?.length))
  .map(e => e.outerHTML.slice(0, 60))"""


class Server:
    """A running studio."""

    def __init__(self, program, folder, budgets=(), port=0, extra=()):
        command = [*program, "studio", "--port", str(port), "--seed", "3", *extra]
        command += ["--out", str(folder), "--keep-token"] if folder else []
        command += [word for budget in budgets for word in ("--set", budget)]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        line = self.process.stdout.readline()
        match = re.search(r"http://([0-9.]+):(\d+)/([0-9a-f]{32})/", line)
        if not match:
            raise RuntimeError(f"the studio did not say where it is: {line!r}")
        self.url, self.port, self.token = match.group(0), int(match.group(2)), match.group(3)

    def end(self, how=signal.SIGINT):
        self.process.send_signal(how)
        self.process.wait(20)


class Page:
    """A page of the studio, asked and driven like a person would."""

    def __init__(self, browser, url):
        self.browser, self.url = browser, url
        for domain in ("Page", "Runtime", "Log", "Network"):
            browser.call(f"{domain}.enable")
        self.scheme("light")
        self.size(1440, 900)
        browser.call("Page.navigate", url=url)

    def scheme(self, name, motion="no-preference"):
        self.browser.call("Emulation.setEmulatedMedia", features=[
            {"name": "prefers-color-scheme", "value": name}, {"name": "prefers-reduced-motion", "value": motion}])

    def size(self, width, height):
        self.browser.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1,
                          mobile=False)

    def ask(self, expression):
        """The value of an expression in the page."""
        answer = self.browser.call("Runtime.evaluate", expression=f"(async () => ({expression}))()",
                                   awaitPromise=True, returnByValue=True)
        if "exceptionDetails" in answer:
            raise RuntimeError(f"{expression}: {answer['exceptionDetails']['exception'].get('description')}")
        return answer["result"].get("value")

    def until(self, expression, what, seconds=20):
        """Waits for an expression to be true."""
        end = time.monotonic() + seconds
        while not self.ask(expression):
            if time.monotonic() > end:
                raise RuntimeError(f"waited {seconds} s in vain: {what}; the page says {self.ask('document.body.innerText.slice(0, 600)')!r}")
            time.sleep(0.05)

    def key(self, name):
        """Presses and releases a key, as a keyboard does."""
        code = KEYS[name]
        text = name if len(name) == 1 else ""
        self.browser.call("Input.dispatchKeyEvent", type="keyDown", key=name, windowsVirtualKeyCode=code, text=text)
        self.browser.call("Input.dispatchKeyEvent", type="keyUp", key=name, windowsVirtualKeyCode=code)

    def click(self, selector):
        """Clicks in the middle of an element."""
        x, y = self.ask(f"(e => {{ e.scrollIntoView({{block: 'center'}}); const b = e.getBoundingClientRect(); "
                        f"return [b.x + b.width / 2, b.y + b.height / 2]; }})(document.querySelector({selector!r}))")
        self.mouse("mousePressed", x, y)
        self.mouse("mouseReleased", x, y)

    def mouse(self, kind, x, y):
        self.browser.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", buttons=1, clickCount=1)

    def drag(self, start, end):
        """Drags with the mouse."""
        self.mouse("mousePressed", *start)
        for share in (0.5, 1.0):
            self.mouse("mouseMoved", *(a + share * (b - a) for a, b in zip(start, end)))
        self.mouse("mouseReleased", *end)

    def touch(self, selector):
        """Taps the middle of an element with a finger."""
        x, y = self.ask(f"(b => [b.x + b.width / 2, b.y + b.height / 2])(document.querySelector({selector!r}).getBoundingClientRect())")
        self.browser.call("Input.dispatchTouchEvent", type="touchStart", touchPoints=[{"x": x, "y": y}])
        self.browser.call("Input.dispatchTouchEvent", type="touchEnd", touchPoints=[])

    def choose(self, select, value):
        """Chooses an option, as a person with a keyboard would."""
        self.ask(f"(e => {{ e.value = {value!r}; e.dispatchEvent(new Event('change')); return e.value; }})"
                 f"(document.getElementById({select!r}))")

    def text(self, element):
        return self.ask(f"document.getElementById({element!r}).textContent")

    def shoot(self, path):
        picture = self.browser.call("Page.captureScreenshot")["data"]
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(base64.b64decode(picture))


def expect(truth, what):
    if not truth:
        raise RuntimeError(what)


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


def operable(page):
    """With the Tab key alone one comes to every control and sees where one is; whoever wants no motion gets none."""
    page.ask("(scrollTo(0, 0), document.activeElement.blur())")
    controls = """[...document.querySelectorAll('button, select, input, canvas[tabindex]')].filter(e =>
      e.getClientRects().length && !e.disabled && e.tabIndex >= 0)"""
    page.ask("window.reached = new Set(), window.unseen = []")
    for _ in range(page.ask(f"{controls}.length") + 3):
        page.key("Tab")
        page.ask("""(e => { reached.add(e); const s = getComputedStyle(e);
          if (e !== document.body && (s.outlineStyle === 'none' || parseFloat(s.outlineWidth) < 2)) unseen.push(e.id || e.textContent); })
          (document.activeElement)""")
    missed = page.ask(f"{controls}.filter(e => !reached.has(e)).map(e => e.id || e.textContent || e.outerHTML.slice(0, 60))")
    expect(not missed, f"the Tab key does not come to {missed}")
    expect(not page.ask("unseen"), f"focus cannot be seen on {page.ask('unseen')}")
    page.ask("document.activeElement.blur()")
    page.scheme("light", "reduce")
    before = page.ask("[studio.stats.frames, studio.where(0)]")
    page.key(".")
    page.until(f"studio.stats.frames > {before[0]}", "a step without motion")
    jumped = page.ask("studio.where(0)")
    expect(jumped != before[1] and jumped == page.ask("new Promise(done => setTimeout(() => done(studio.where(0)), 120))"),
           "the car is at once where it goes")
    page.scheme("light")


def pace(page):
    """What reaches the page each second while it watches a run, and how often the browser draws."""
    return page.ask("""new Promise(done => { const from = {...studio.stats}, start = performance.now(); let drawn = 0;
      const count = () => { drawn += 1; const secs = (performance.now() - start) / 1000;
        if (secs < 3) requestAnimationFrame(count);
        else done([(studio.stats.frames - from.frames) / secs, (studio.stats.bytes - from.bytes) / secs / 1000, drawn / secs]); };
      requestAnimationFrame(count); })""")


def speeds(page):
    """Every speed can be chosen, and the studio goes by it."""
    for value in ("0.25", "0.5", "1", "2", "4", "8", "0", "16"):
        page.choose("speed", value)
        page.until(f"studio.status().times === {value}", f"speed {value}")


def timeline(page):
    """Pause, scrub back, see an older decision, and come back."""
    page.ask("document.activeElement.blur()")
    page.choose("driver", "0")
    speeds(page)
    if page.ask("document.querySelector('#run .word').textContent === 'Run'"):
        page.click("#run")
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
    step = page.text("facts")
    page.key(".")
    page.until(f"document.getElementById('facts').textContent !== {step!r}", "a single step")


def compare(page):
    """Two drivers on the same road."""
    page.choose("rival", "1")
    page.until("document.querySelectorAll('.lane canvas').length === 2", "two lanes")
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


def look_closely(page, scheme):
    """Contrast, names, width: the page is for everybody."""
    page.scheme(scheme)
    for tab in ("curves", "stage"):
        page.click(f"#tab-{tab}")
        pale, nameless = page.ask(PALE), page.ask(NAMELESS)
        expect(not pale, f"{scheme} {tab}: too pale: {pale}")
        expect(not nameless, f"{scheme} {tab}: without a name: {nameless}")
    for width in (1440, 1024, 768):
        page.size(width, 900)
        wide = page.ask("document.documentElement.scrollWidth - document.documentElement.clientWidth")
        expect(wide <= 0, f"at {width} pixels the page is {wide} too wide")
    page.size(1440, 900)


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


def talk(port, lines, wait=3.0):
    """Sends a raw request and returns the first line of the answer."""
    with socket.create_connection(("127.0.0.1", port), timeout=wait) as link:
        link.sendall("\r\n".join([*lines, "", ""]).encode())
        answer = b""
        while b"\r\n" not in answer:
            part = link.recv(4096)
            if not part:
                break
            answer += part
    return answer.split(b"\r\n")[0].decode()


def attack(server):
    """Everything that must not work, and what must."""
    port, token, host = server.port, server.token, f"Host: 127.0.0.1:{server.port}"
    upgrade = ["Connection: Upgrade", "Upgrade: websocket", "Sec-WebSocket-Version: 13",
               "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ=="]
    own = f"Origin: http://127.0.0.1:{port}"
    live = f"GET /{token}/live HTTP/1.1"
    trials = [
        ("the page with its token", [f"GET /{token}/ HTTP/1.1", host], "200"),
        ("a socket from the page", [live, host, own, *upgrade], "101"),
        ("no token", ["GET / HTTP/1.1", host], "403"),
        ("a wrong token", [f"GET /{'0' * 32}/ HTTP/1.1", host], "403"),
        ("a token with a wrong end", [f"GET /{token[:-1]}/ HTTP/1.1", host], "403"),
        ("DNS rebinding", [f"GET /{token}/ HTTP/1.1", "Host: evil.example"], "421"),
        ("a name that looks local", [f"GET /{token}/ HTTP/1.1", "Host: localhost.evil.example"], "421"),
        ("no host", [f"GET /{token}/ HTTP/1.0"], "421"),
        ("a socket of another page", [live, host, "Origin: http://evil.example", *upgrade], "403"),
        ("a socket of another port", [live, host, "Origin: http://127.0.0.1:1", *upgrade], "403"),
        ("a socket of nowhere", [live, host, "Origin: null", *upgrade], "403"),
        ("a socket without origin", [live, host, *upgrade], "403"),
        ("a socket without token", ["GET /live HTTP/1.1", host, own, *upgrade], "403"),
        ("a request of another page", [f"GET /{token}/world.json HTTP/1.1", host, "Sec-Fetch-Site: cross-site"], "403"),
        ("a file above", [f"GET /{token}/../../etc/passwd HTTP/1.1", host], "404"),
        ("a file above, disguised", [f"GET /{token}/%2e%2e%2f%2e%2e%2fetc%2fpasswd HTTP/1.1", host], "404"),
        ("a drawing that is a path", [f"GET /{token}/draw/..%2f..%2frun.json HTTP/1.1", host], "404"),
        ("the kept token", [f"GET /{token}/studio.token HTTP/1.1", host], "404"),
        ("writing", [f"POST /{token}/ HTTP/1.1", host, "Content-Length: 0"], "405"),
        ("deleting", [f"DELETE /{token}/ HTTP/1.1", host], "405"),
    ]
    for what, lines, wanted in trials:
        status = (talk(port, lines).split() + ["", "nothing"])[1]
        expect(status == wanted, f"{what}: {status}, not {wanted}")
    return len(trials)


class Wire:
    """A WebSocket by hand, for a page that misbehaves."""

    def __init__(self, server):
        self.link = socket.create_connection(("127.0.0.1", server.port), timeout=5)
        host = f"127.0.0.1:{server.port}"
        lines = [f"GET /{server.token}/live HTTP/1.1", f"Host: {host}", f"Origin: http://{host}", "Connection: Upgrade",
                 "Upgrade: websocket", "Sec-WebSocket-Version: 13", "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==", "", ""]
        self.link.sendall("\r\n".join(lines).encode())
        self.buffer = b""
        while b"\r\n\r\n" not in self.buffer:
            self.buffer += self.link.recv(4096)
        self.buffer = self.buffer.split(b"\r\n\r\n", 1)[1]

    def send(self, text):
        body = text.encode()
        size = bytes([0x80 | len(body)]) if len(body) < 126 else bytes([0xFE]) + len(body).to_bytes(2, "big")
        self.link.sendall(b"\x81" + size + b"\0\0\0\0" + body)

    def take(self, count):
        while len(self.buffer) < count:
            part = self.link.recv(65536)
            if not part:
                raise ConnectionError("closed")
            self.buffer += part
        part, self.buffer = self.buffer[:count], self.buffer[count:]
        return part

    def hear(self, kind, messages=200):
        """The next message of this kind."""
        for _ in range(messages):
            code, size = self.take(2)
            if size > 125:
                size = int.from_bytes(self.take(2 if size == 126 else 8), "big")
            body = self.take(size)
            news = json.loads(body) if code == 0x81 else {}
            if kind in news:
                return news[kind]
            if code == 0x88:
                raise ConnectionError("closed")
        raise RuntimeError(f"no {kind} among {messages} messages")


def share(page, server):
    """A second page watches; only the holder of the wheel drives; nonsense is refused and hurts nobody."""
    guest = Wire(server)
    name = guest.hear("hello")["you"]
    while guest.hear("status")["pages"] != 2:
        pass
    guest.send('{"do":"pause"}')
    expect("watching" in guest.hear("refused"), "a guest cannot drive")
    for nonsense in ("", "{", '{"do":"rm -rf /"}', '{"do":"recall","decision":-1}', '{"do":"press","action":99}'):
        guest.send(nonsense)
        expect(guest.hear("refused"), f"{nonsense!r} is refused")
    guest.send('{"do":"recall","decision":999999999}')
    expect(guest.hear("past") is None, "there is no such decision")
    page.click("#wheel")
    page.until("document.getElementById('wheel').textContent.startsWith('Take')", "the wheel is let go")
    guest.send('{"do":"take_wheel"}')
    while guest.hear("status")["wheel"] != name:
        pass
    page.until("document.getElementById('wheel').textContent === 'Watching'", "the page sees that it only watches")
    guest.send('{"do":"place","body":0,"x":1e300,"y":0}')
    while not guest.hear("status")["notice"]:
        pass
    guest.send("x" * 5000)
    try:
        guest.hear("never", 10_000)
        expect(False, "a request of 5000 bytes is too long")
    except (ConnectionError, TimeoutError):
        pass
    page.until("document.getElementById('wheel').textContent.startsWith('Take')", "a wheel without holder is free")
    page.click("#wheel")
    page.until("document.getElementById('wheel').textContent.startsWith('You')", "and can be taken")


def photograph(page, pictures):
    """The pictures of the guide, light and dark: a trained mind that attends, and how it learned to."""
    page.click("#tab-curves")
    page.click("#train")
    page.until("[...document.getElementById('driver').options].some(o => o.text === 'ACL, trained here')",
               "attention control is trained", 400)
    page.click("#stop")
    page.until("document.getElementById('training-note').textContent.startsWith('stopped')", "the rest can wait")
    page.choose("phase", "attention")
    page.click("#tab-stage")
    page.choose("driver", page.ask("[...document.getElementById('driver').options].findIndex(o => o.text === 'ACL, trained here')"))
    page.choose("speed", "16")
    if page.ask("document.querySelector('#run .word').textContent === 'Run'"):
        page.click("#run")
    page.until("Number(document.getElementById('scrub').max) > 0 && Number(document.getElementById('scrub').value) > 500",
               "it drives", 120)
    page.click("#run")
    page.click("#scenes li:nth-child(4) button")
    page.until("document.querySelectorAll('#looks b').length > 0", "it looks")
    for scheme in ("light", "dark"):
        page.scheme(scheme, "reduce")
        for tab in ("stage", "curves"):
            page.size(1440, 900 if tab == "stage" else 1060)
            page.click(f"#tab-{tab}")
            page.ask("(scrollTo(0, 0), document.activeElement.blur(), new Promise(done => setTimeout(done, 2600)))")
            page.shoot(pictures / f"studio-{tab}-{scheme}.png")


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


def give_up(_signal, _frame):
    raise TimeoutError(f"the studio was not done after {SECONDS} s")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--metal", type=pathlib.Path, help="the program; built and run by cargo if left out")
    parser.add_argument("--screenshots", type=pathlib.Path, help="folder for pictures")
    arguments = parser.parse_args()
    program = [str(arguments.metal)] if arguments.metal else ["cargo", "run", "--quiet", "-p", "metal-cli", "--"]
    signal.signal(signal.SIGALRM, give_up)
    signal.alarm(SECONDS)
    scratch = pathlib.Path(tempfile.mkdtemp())
    folder, started = scratch / "run", time.monotonic()
    budgets = PICTURE_BUDGETS if arguments.screenshots else []
    server = Server(program, folder, budgets)
    browser = Browser(str(scratch / "profile"))
    try:
        page = Page(browser, server.url)
        page.until("window.studio?.stats.frames > 0 && document.querySelectorAll('#supports td').length > 0", "the stage")
        if arguments.screenshots:
            signal.alarm(PICTURE_SECONDS)
            photograph(page, arguments.screenshots)
            return 0
        for part in (lambda: demonstrate(page, folder), lambda: explore(page), lambda: timeline(page),
                     lambda: compare(page), lambda: operable(page), lambda: share(page, server)):
            part()
        page.click("#clip")
        told = train(page)
        for scheme in ("light", "dark"):
            look_closely(page, scheme)
        page.click("#tab-curves")
        stop_training(page)
        page.until("studio.kept?.name === 'metal-clip.webm' && studio.kept.bytes > 20000", "a clip is kept")
        keep(page)
        wrong = [c for c in complaints_of_console(browser.events, server.url) if not is_own(c, server)]
        expect(not wrong, f"the page complained: {wrong[:5]}")
        browser.events.clear()
        server = lose_and_find(page, server, program, folder)
        attacks = attack(server)
        looks = watch_body(page, server, program, scratch)
        print(f"studio: {STEPS} steps shown, {DECISIONS} decisions watched, {attacks} attacks, a body watched for {looks} "
              f"decisions, {time.monotonic() - started:.0f} s")
        print("studio: the page got {:.1f} frames/s and {:.0f} kB/s and drew {:.0f} times a second".format(*told))
    finally:
        browser.close()
        server.end()
        shutil.rmtree(scratch, ignore_errors=True)
    return 0


def is_own(complaint, server):
    """Requests to the studio itself are no complaint; neither is a chart that has nothing to draw yet."""
    return server.url in complaint and ("asks for" in complaint or "/draw/" in complaint) or "asks for blob:" in complaint


if __name__ == "__main__":
    sys.exit(main())
