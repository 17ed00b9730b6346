"""A running studio, and a page of it that is asked and driven like a person would."""

import base64
import re
import signal
import subprocess
import time

KEYS = {"Tab": 9, "Escape": 27, "ArrowUp": 38, "ArrowRight": 39, "ArrowLeft": 37, "m": 77, "s": 83, "u": 85, ".": 190}


class Server:
    """A running studio."""

    def __init__(self, program, folder, budgets=(), port=0, extra=(), stderr=None):
        command = [*program, "studio", "--port", str(port), "--seed", "3", *extra]
        command += ["--out", str(folder), "--keep-token"] if folder else []
        command += [word for budget in budgets for word in ("--set", budget)]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=stderr, text=True)
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
