#!/usr/bin/env python3
"""Opens report.html in headless Chromium, light and dark, and refuses it unless it is whole.

    check_report.py REPORT [--screenshots DIR]

Whole means: nothing is loaded from anywhere else, the console stays silent, every figure and table is there and
visible, text stands out from its background in both colour schemes, and the page does not scroll sideways. Needs
only Chromium: it speaks the DevTools protocol over a pipe.
"""

import argparse
import base64
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile

FIGURES = ["headline", "fig6", "fig8", "fig9", "fig11", "subset-front", "look-map", "sensitivity"]
# Section, least number of tables in it, least number of rows in all of them.
TABLES = [("summary", 2, 8), ("table2", 1, 9), ("table3", 1, 5), ("behaviour", 1, 3), ("baselines", 1, 7)]
SITUATIONS = 6
FLAGS = [
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync", "--hide-scrollbars",
]
LEAST_CONTRAST = 3.0
SECONDS = 60

# Everything the page is asked, in one expression that gives JSON.
QUESTIONS = """(() => {
  const seen = e => { const b = e.getBoundingClientRect(); return b.width > 20 && b.height > 20; };
  const rgb = text => (text.match(/[0-9.]+/g) || [0, 0, 0]).slice(0, 3).map(Number);
  const light = c => rgb(c).map(v => v / 255).map(v => v <= 0.03928 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4)
    .reduce((sum, v, i) => sum + v * [0.2126, 0.7152, 0.0722][i], 0);
  const page = getComputedStyle(document.body);
  const root = getComputedStyle(document.documentElement);
  const transparent = page.backgroundColor === 'rgba(0, 0, 0, 0)';
  const paper = light(transparent ? root.backgroundColor : page.backgroundColor), ink = light(page.color);
  const section = id => [...document.querySelectorAll('#' + id + ' table')];
  return JSON.stringify({
    title: document.title,
    figures: Object.fromEntries([...document.querySelectorAll('figure')].map(f => [f.id.replace('figure-', ''),
      [...f.querySelectorAll('svg')].filter(seen).length])),
    tables: Object.fromEntries([...document.querySelectorAll('main > section')].map(s => [s.id,
      [section(s.id).length, section(s.id).reduce((n, t) => n + t.querySelectorAll('tbody tr').length, 0)]])),
    scenes: [...document.querySelectorAll('.scene svg')].filter(seen).length,
    missing: [...document.querySelectorAll('.notrun, .scene .missing')].map(p =>
      p.closest('section').id + ': ' + p.textContent.trim()),
    broken: (document.body.innerText.match(/NaN|undefined|\\[object/g) || []).length,
    sideways: document.documentElement.scrollWidth - document.documentElement.clientWidth,
    dark: paper < ink,
    contrast: (Math.max(paper, ink) + 0.05) / (Math.min(paper, ink) + 0.05),
  });
})()"""


class Browser:
    """Chromium with one page, driven over a pipe."""

    def __init__(self, profile):
        to_browser, self._out = os.pipe()
        self._in, from_browser = os.pipe()

        # The browser reads commands from descriptor 3 and answers on 4. Moving the ends up first keeps the two
        # copies from overwriting each other.
        def connect():
            high = [os.dup2(to_browser, 103), os.dup2(from_browser, 104)]
            for target, source in zip((3, 4), high):
                os.dup2(source, target, inheritable=True)

        command = [shutil.which("chromium") or "chromium", *FLAGS, f"--user-data-dir={profile}",
                   "--remote-debugging-pipe", "about:blank"]
        self._process = subprocess.Popen(command, preexec_fn=connect, close_fds=False, stderr=subprocess.DEVNULL,
                                         stdout=subprocess.DEVNULL)
        os.close(to_browser)
        os.close(from_browser)
        self._buffer, self._number, self.events = b"", 0, []
        targets = self.call("Target.getTargets")["targetInfos"]
        page = next(t["targetId"] for t in targets if t["type"] == "page")
        self._session = None
        self._session = self.call("Target.attachToTarget", targetId=page, flatten=True)["sessionId"]

    def _receive(self):
        while b"\0" not in self._buffer:
            chunk = os.read(self._in, 1 << 20)
            if not chunk:
                raise RuntimeError("the browser went away")
            self._buffer += chunk
        message, self._buffer = self._buffer.split(b"\0", 1)
        return json.loads(message)

    def call(self, method, **params):
        """Sends a command and returns its result; events that come in between are kept."""
        self._number += 1
        message = {"id": self._number, "method": method, "params": params}
        if getattr(self, "_session", None):
            message["sessionId"] = self._session
        os.write(self._out, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._receive()
            if answer.get("id") == self._number:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']['message']}")
                return answer["result"]
            self.events.append(answer)

    def wait_for(self, method):
        """Waits for an event."""
        while not any(event.get("method") == method for event in self.events):
            self.events.append(self._receive())

    def close(self):
        """Ends the browser."""
        self._process.terminate()
        self._process.wait(10)


def complaints_of_console(events, address):
    """What the console, the network and the scripts had to say, and every address beside the page's own."""
    for event in events:
        method, params = event.get("method"), event.get("params", {})
        if method == "Log.entryAdded" and params["entry"]["level"] in ("error", "warning"):
            yield f"console: {params['entry']['text']} {params['entry'].get('url', '')}"
        elif method == "Runtime.consoleAPICalled" and params["type"] in ("error", "warning", "assert"):
            yield f"console: {params['args']}"
        elif method == "Runtime.exceptionThrown":
            yield f"script: {params['exceptionDetails']['text']}"
        elif method == "Network.loadingFailed":
            yield f"not loaded: {params['errorText']}"
        elif method == "Network.requestWillBeSent":
            url = params["request"]["url"]
            if url != address and not url.startswith("data:"):
                yield f"asks for {url}"


def complaints_of_page(page, scheme):
    """What the page lacks."""
    for name in FIGURES:
        if page["figures"].get(name, 0) == 0:
            yield f"figure `{name}` is not there"
    for name, drawings in page["figures"].items():
        if drawings == 0:
            yield f"figure `{name}` is empty"
    for name, tables, rows in TABLES:
        found = page["tables"].get(name, [0, 0])
        if found[0] < tables or found[1] < rows:
            yield f"section `{name}` has {found[0]} tables with {found[1]} rows, not {tables} with {rows}"
    if page["scenes"] != SITUATIONS:
        yield f"{page['scenes']} situations are drawn, not {SITUATIONS}"
    yield from (f"left out in {missing}" for missing in page["missing"])
    if page["broken"]:
        yield f"{page['broken']} texts are NaN, undefined or an object"
    if page["sideways"] > 0:
        yield f"the page is {page['sideways']} pixels too wide"
    if page["dark"] != (scheme == "dark"):
        yield "the page does not follow the colour scheme"
    if page["contrast"] < LEAST_CONTRAST:
        yield f"text has a contrast of only {page['contrast']:.1f}"


def look(browser, address, scheme, screenshot):
    """Opens the page in one colour scheme and returns everything that is wrong with it."""
    browser.events.clear()
    for domain in ("Page", "Runtime", "Log", "Network"):
        browser.call(f"{domain}.enable")
    browser.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])
    browser.call("Emulation.setDeviceMetricsOverride", width=1280, height=900, deviceScaleFactor=1, mobile=False)
    browser.call("Page.navigate", url=address)
    browser.wait_for("Page.loadEventFired")
    page = json.loads(browser.call("Runtime.evaluate", expression=QUESTIONS)["result"]["value"])
    if screenshot:
        picture = browser.call("Page.captureScreenshot", captureBeyondViewport=True)["data"]
        screenshot.write_bytes(base64.b64decode(picture))
    return page, [*complaints_of_console(browser.events, address), *complaints_of_page(page, scheme)]


def give_up(_signal, _frame):
    """A browser that hangs must not hang the tests."""
    raise TimeoutError(f"the browser was not done after {SECONDS} s")


def main():
    """Looks at the report in both colour schemes."""
    signal.signal(signal.SIGALRM, give_up)
    signal.alarm(SECONDS)
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("report", type=pathlib.Path)
    parser.add_argument("--screenshots", type=pathlib.Path, help="folder for a picture of each colour scheme")
    arguments = parser.parse_args()
    address = arguments.report.resolve(strict=True).as_uri()
    failed = False
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        browser = Browser(profile)
        try:
            for scheme in ("light", "dark"):
                picture = arguments.screenshots / f"report-{scheme}.png" if arguments.screenshots else None
                page, wrong = look(browser, address, scheme, picture)
                drawings = sum(page["figures"].values()) + page["scenes"]
                rows = sum(rows for _, rows in page["tables"].values())
                print(f"{scheme}: {drawings} drawings, {rows} table rows, contrast {page['contrast']:.1f}")
                for complaint in wrong:
                    print(f"  {scheme}: {complaint}", file=sys.stderr)
                failed = failed or bool(wrong)
        finally:
            browser.close()
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
