#!/usr/bin/env python3
"""What a look and a decision cost on the link of each body, with attention and without, as two tables in Markdown.

    measure_links.py METAL RUN

METAL plays each body itself (`metal serve`; the serial line at 115200 baud), examines it (`metal doctor`: five looks at the
whole picture and at the ring each) and drives it with a mind of RUN (a folder that `metal reproduce` wrote): with the policy
`acl`, which pays attention, and with `foa`, which looks at everything. Milliseconds are those of waiting for answers.
"""

import re
import subprocess
import sys

STEPS = 40
BODIES = [
    ("E-puck, serial at 115200 baud", ["epuck", "--baud", "115200"], "epuck://{}"),
    ("the same, camera cropped", ["epuck", "--baud", "115200"], "epuck://{}?crop"),
    ("e-puck2, TCP", ["epuck2", "--bind", "127.0.0.1:0"], "epuck2://{}"),
    ("Webots, TCP", ["webots", "--bind", "127.0.0.1:0"], "webots://{}/learner"),
]
COST = re.compile(r"a decision: (\d+) bytes and ([\d.]+) ms on the link")
SAVED = re.compile(r"on the link, (-?\d+) bytes and (-?[\d.]+) ms less")
LOOKS = re.compile(r"^\s+0\s+\S+\s+\S+\s+([\d.]+)$", re.M)
LOOK = re.compile(r"^a look at (\S+): (\d+) bytes, ([\d.]+) ms$", re.M)
EXAMINED = re.compile(r"(infra-red ring|camera) .*?(\d+) bytes and ([\d.]+) ms a look")


def say(metal, *words):
    return subprocess.run([metal, *words], capture_output=True, text=True, check=True, timeout=200).stdout


def drive(metal, run, address, policy):
    """What the drive says: bytes, milliseconds and looks of a decision, and what was saved."""
    said = say(metal, "drive", "--robot", address, "--run", run, "--policy", policy, "--steps", str(STEPS))
    cost, saved = COST.search(said), SAVED.search(said)
    return [int(cost[1]), float(cost[2]), float(LOOKS.search(said)[1]), int(saved[1]), float(saved[2])], LOOK.findall(said)


def measure(metal, run, address):
    """Rows for the two tables."""
    examined = {what: (size, ms) for what, size, ms in EXAMINED.findall(say(metal, "doctor", "--robot", address))}
    (whole, regions), (part, _) = drive(metal, run, address, "foa"), drive(metal, run, address, "acl")
    looks = [f"whole picture {examined['camera'][0]} bytes, {examined['camera'][1]} ms",
             f"ring {examined['infra-red ring'][0]} bytes, {examined['infra-red ring'][1]} ms",
             *(f"{name} {size} bytes, {ms} ms" for name, size, ms in regions)]
    return looks, f"{whole[0]} | {whole[1]:.2f} | {part[0]} | {part[1]:.2f} | {part[2]:.1f} | {part[3]} | {part[4]:.2f}"


def main():
    metal, run = sys.argv[1:]
    looks, decisions = [], []
    for name, played, address in BODIES:
        server = subprocess.Popen([metal, "serve", *played], stdout=subprocess.PIPE, text=True)
        try:
            place = server.stdout.readline().strip().removeprefix("listening at ")
            seen, decided = measure(metal, run, address.format(place))
        finally:
            server.terminate()
            server.wait()
        looks.append(f"| {name} | {'; '.join(seen)} |")
        decisions.append(f"| {name} | {decided} |")
    print("| body | a look |\n|---|---|", *looks, sep="\n")
    print("\n| body | everything: bytes | ms | attention: bytes | ms | members asked | saved bytes | saved ms |")
    print("|---|---|---|---|---|---|---|---|", *decisions, sep="\n")


main()
