#!/usr/bin/env python3
"""What a decision costs on the link of each body, with attention and without, as a table in Markdown.

    measure_links.py METAL RUN

METAL plays each body itself (`metal serve`; the serial line at 115200 baud) and drives it with a mind of RUN (a folder that
`metal reproduce` wrote): with the policy `acl`, which pays attention, and with `foa`, which looks at everything.
"""

import re
import subprocess
import sys

STEPS = 20
BODIES = [
    ("E-puck, serial at 115200 baud", ["epuck", "--baud", "115200"], "epuck://{}"),
    ("the same, camera cropped", ["epuck", "--baud", "115200"], "epuck://{}?crop"),
    ("e-puck2, TCP", ["epuck2", "--bind", "127.0.0.1:0"], "epuck2://{}"),
    ("Webots, TCP", ["webots", "--bind", "127.0.0.1:0"], "webots://{}/learner"),
]
COST = re.compile(r"a decision: (\d+) bytes and ([\d.]+) ms on the link")
LOOKS = re.compile(r"^\s+0\s+\S+\s+\S+\s+([\d.]+)$", re.M)


def drive(metal, run, address, policy):
    """Bytes, milliseconds and looks of a decision."""
    command = [metal, "drive", "--robot", address, "--run", run, "--policy", policy, "--steps", str(STEPS)]
    said = subprocess.run(command, capture_output=True, text=True, check=True, timeout=120).stdout
    return int(COST.search(said)[1]), float(COST.search(said)[2]), float(LOOKS.search(said)[1])


def main():
    metal, run = sys.argv[1:]
    print("| body | everything: bytes | ms | attention: bytes | ms | members asked |")
    print("|---|---|---|---|---|---|")
    for name, played, address in BODIES:
        server = subprocess.Popen([metal, "serve", *played], stdout=subprocess.PIPE, text=True)
        try:
            place = server.stdout.readline().strip().removeprefix("listening at ")
            whole, part = [drive(metal, run, address.format(place), policy) for policy in ("foa", "acl")]
        finally:
            server.terminate()
            server.wait()
        print(f"| {name} | {whole[0]} | {whole[1]:.1f} | {part[0]} | {part[1]:.1f} | {part[2]:.1f} |", flush=True)


main()
