#!/usr/bin/env python3
"""Drives `metal studio` in headless Chromium with real keys, then attacks it.

    check_studio.py [--metal PROGRAM] [--screenshots DIR]

The first part is a person: demonstrates thirty steps, finds them on disk, watches a run train, scrubs back, opens a
situation of Table 1, drags a car, breaks a sensor, compares two drivers, loses the server and gets it back, watches a
body and a run that was killed. The second part is an attacker without the token, with a foreign name, with a foreign
page. Needs only Chromium: it speaks the DevTools protocol over a pipe, as check_report.py does. With --screenshots it only takes the pictures of the guide.
"""

import argparse
import pathlib
import shutil
import signal
import sys
import tempfile
import time

from check_report import Browser, complaints_of_console
from studio.attacks import Wire, abroad, attack, share
from studio.body import watch_body
from studio.everybody import look_closely, operable
from studio.page import Page, Server, expect
from studio.pictures import PICTURE_BUDGETS, PICTURE_SECONDS, photograph
from studio.unfinished import watch_unfinished
from studio.tour import (DECISIONS, STEPS, autosave, compare, demonstrate, explore, keep, lose_and_find, stop_training, timeline,
                         train)

SECONDS = 170


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
        for part in (lambda: demonstrate(page, folder), lambda: autosave(page, folder), lambda: explore(page), lambda: timeline(page),
                     lambda: compare(page), lambda: operable(page), lambda: share(page, server)):
            part()
        page.click("#clip")
        deaf = Wire(server)  # a page that never reads holds up neither the run nor the others
        told = train(page)
        deaf.link.close()
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
        abroad(program, scratch)
        looks = watch_body(page, server, program, scratch)
        watch_unfinished(page, program, scratch)
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
