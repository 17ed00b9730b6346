#!/usr/bin/env python3
"""Enki, the simulator of EPFL (GPL: it runs here as a separate program), against our arena.

    enki.py PATHS FIGURE

PATHS is our example program. Without arguments it prints JSON: a program of wheel speeds, our path, our way to a
standstill before a disc, and our infra-red readings at gaps. Given an axle it follows wheel speeds from its standard
input. Enki does the same, and FIGURE (SVG) shows both.

Enki differs from us in three things that have nothing to do with how wheels move a body, all read in its source
(DifferentialWheeled.cpp, EPuck.cpp, World::step): its axle is 51 mm, ours (Webots') 52 mm; a command turns the wheels
one step later, because a step moves bodies before it asks robots what they want; and each wheel's speed is wrong by up to
5 %, evenly and anew in each step. So there are two comparisons: with the speeds that its wheels really had (its
encoders), which leaves nothing to chance, and with the commands alone, against the spread of its runs.
"""

import json
import math
import subprocess
import sys

import pyenki

SEEDS = 60
AXLE_M = 0.051
# Enki turns the heading of a step by half of the *last* step's turn, so that each change of the command shifts the path
# by some micrometres.
FOLLOWED_M = 0.0001


def fail(message):
    sys.exit(f"enki judge: {message}")


class Drive:
    """One robot alone, driven by a program of (left, right, seconds) in metres per second."""

    def __init__(self, seed, program, step, disc_x_m=None):
        world, robot = fresh(seed)
        if disc_x_m is not None:
            disc(world, disc_x_m)
        self.path, self.wheels = [(0.0, 0.0, 0.0)], []
        commands = [c for c in program for _ in range(round(c[2] / step))]
        # Once more: a command turns the wheels in the step after.
        for left, right, _ in [*commands, (0.0, 0.0, 0.0)]:
            # Enki counts in centimetres.
            robot.leftSpeed, robot.rightSpeed = 100 * left, 100 * right
            world.step(step, 3)
            self.path.append((robot.pos[0] / 100, robot.pos[1] / 100, robot.angle))
            self.wheels.append((robot.leftEncoder / 100, robot.rightEncoder / 100))
        # The first step stands, and the wheels of the last belong to a step that nobody makes.
        del self.path[0], self.wheels[-1]


def fresh(seed):
    world = pyenki.World()
    world.setRandomSeed(seed)
    robot = pyenki.EPuck()
    robot.pos, robot.angle = (0.0, 0.0), 0.0
    world.addObject(robot)
    return world, robot


def disc(world, x_m):
    # As heavy as a wall: Enki pushes what is light, our standing cars stay where they are.
    body = pyenki.CircularObject(3.7, 4.75, -1)
    body.pos = (100 * x_m, 0.0)
    world.addObject(body)


def follow(paths, wheels, axle_m, step):
    """Where our kinematics lead with these wheel speeds."""
    text = "".join(f"{left!r} {right!r}\n" for left, right in wheels)
    out = subprocess.run([paths, str(axle_m), str(step)], input=text, capture_output=True, text=True, check=True,
                         timeout=60).stdout
    return [(0.0, 0.0, 0.0)] + [tuple(map(float, line.split())) for line in out.splitlines()]


def apart(a, b):
    return math.hypot(a[0] - b[0], a[1] - b[1])


def noise(runs):
    """Mean position and root mean square distance from it, at each step."""
    bands = []
    for points in zip(*(run.path for run in runs), strict=True):
        mean = [sum(p[i] for p in points) / len(points) for i in range(2)]
        bands.append((mean, math.sqrt(sum(apart(p, mean) ** 2 for p in points) / len(points))))
    return bands


def paths_agree(paths, ours, runs):
    """The two comparisons, and the same commands on Enki's axle."""
    step, program = ours["step_secs"], ours["program"]
    length = sum(0.5 * abs(l + r) * s for l, r, s in program)
    worst = max(apart(a, b) for run in runs for a, b in zip(run.path, follow(paths, run.wheels, AXLE_M, step), strict=True))
    print(f"  wheels as they really turned, {len(runs)} runs of {1000 * length:.0f} mm: never more than {1000 * worst:.2f} mm apart")
    if worst > FOLLOWED_M:
        fail(f"the same wheel speeds lead more than {1000 * FOLLOWED_M} mm apart")
    commands = [(l, r) for l, r, s in program for _ in range(round(s / step))]
    same_axle, bands = follow(paths, commands, AXLE_M, step), noise(runs)
    offs = [apart(p, mean) for p, (mean, _) in zip(same_axle, bands, strict=True)]
    shares = [off / max(spread, 1e-4) for off, (_, spread) in zip(offs, bands)]
    print(f"  the commands alone, on Enki's axle: ends {1000 * offs[-1]:.1f} mm from the mean of its runs, one run spreads by "
          f"{1000 * bands[-1][1]:.1f} mm; never farther than {max(shares):.2f} spreads")
    # The mean itself is known to a spread over the root of the number of runs, in each of two directions.
    if any(off > 3.5 * spread / math.sqrt(len(runs)) + FOLLOWED_M for off, (_, spread) in zip(offs, bands)):
        fail("our path leaves the mean of Enki's by more than its motor noise explains")
    own = [apart(p, mean) for p, (mean, _) in zip(ours["path"], bands, strict=True)]
    print(f"  the commands alone, on our axle of 52 mm: ends {1000 * own[-1]:.1f} mm from that mean")
    return same_axle, bands


def standstill(ours):
    end = Drive(1, [(0.1, 0.1, 4.0)], ours["step_secs"], ours["disc_x_m"]).path[-1]
    gap = ours["disc_x_m"] - end[0]
    print(f"  standstill before a disc: centres {1000 * gap:.1f} mm apart in Enki, {1000 * ours['stop_distance_m']:.1f} mm in ours")
    if abs(gap - ours["stop_distance_m"]) > 0.004:
        fail("the bodies come to a stand at different places")


def infrared(gap_m):
    """Mean reading of ps0 with a disc straight ahead."""
    world, robot = fresh(3)
    disc(world, 0.074 + gap_m)
    total = 0.0
    for _ in range(50):
        world.step(0.02, 1)
        total += robot.proximitySensorValues[0]
    return total / 50


def laws(ours):
    law = [(g, m, infrared(g)) for g, m in ours["infrared"]]
    for gap_m, we, they in law:
        print(f"  gap {1000 * gap_m:4.0f} mm: ps0 reads {we:6.0f} in ours (Webots' law, red body), {they:6.0f} in Enki")
    falls = lambda column: all(a[column] >= b[column] - 30 for a, b in zip(law, law[1:]))
    if not (falls(1) and falls(2)):
        fail("a reading grows with distance")
    return law


def main():
    paths, figure_file = sys.argv[1:]
    ours = json.loads(subprocess.run([paths], capture_output=True, text=True, check=True, timeout=60).stdout)
    runs = [Drive(seed, ours["program"], ours["step_secs"]) for seed in range(SEEDS)]
    same_axle, bands = paths_agree(paths, ours, runs)
    standstill(ours)
    law = laws(ours)
    with open(figure_file, "w") as file:
        file.write(figure(ours, runs, (same_axle, bands), law))


def line(points, style):
    # Every fifth point: nobody sees the others.
    points = [*points[:-1:5], points[-1]] if len(points) > 100 else points
    return f"<polyline fill='none' {style} points='" + " ".join(f"{x:.1f},{y:.1f}" for x, y in points) + "'/>"


def text(x, y, words):
    return f"<text x='{x}' y='{y}'>{words}</text>"


BLACK, RED, BLUE = "stroke='#111' stroke-width='1.6'", "stroke='#c33' stroke-width='0.5' opacity='0.35'", \
    "stroke='#36c' stroke-width='1.4' stroke-dasharray='5 3'"
STRONG_RED = "stroke='#c33' stroke-width='1.6'"


def figure(ours, runs, compared, law):
    """The paths, how far apart they are, and the two infra-red laws."""
    parts = ["<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 960 400' font-family='sans-serif' font-size='12'>",
             "<rect width='960' height='400' fill='white'/>",
             *ways(ours, runs, compared[0]), *distances(ours, compared), *curves(law), "</svg>"]
    return "\n".join(parts) + "\n"


def ways(ours, runs, same_axle):
    points = [p for path in [ours["path"], *(run.path for run in runs)] for p in path]
    x0, y0 = min(p[0] for p in points), max(p[1] for p in points)
    scale = 270 / max(max(p[0] for p in points) - x0, y0 - min(p[1] for p in points), 1e-9)
    at = lambda path: [(20 + scale * (p[0] - x0), 40 + scale * (y0 - p[1])) for p in path]
    return [*[line(at(run.path), RED) for run in runs], line(at(same_axle), BLACK), line(at(ours["path"]), BLUE),
            text(20, 25, "One program of wheel speeds"),
            text(20, 350, f"red: {len(runs)} runs of Enki with its motor noise"),
            text(20, 367, "black: ours on Enki's axle (51 mm)"), text(20, 384, "blue: ours on our own axle (52 mm)")]


def distances(ours, compared):
    same_axle, bands = compared
    secs, most = ours["step_secs"], 14.0
    at = lambda values: [(370 + 20 * i * secs, 320 - 280 * 1000 * v / most) for i, v in enumerate(values)]
    off = lambda path: [apart(p, mean) for p, (mean, _) in zip(path, bands)]
    spread = [s for _, s in bands]
    ticks = [text(345, 324 - 280 * mm / most, str(mm)) for mm in (0, 5, 10)]
    return ["<path d='M370 40V320H610' fill='none' stroke='#888'/>", *ticks, text(345, 25, "mm from the mean of Enki's runs"),
            line(at(spread), STRONG_RED), line(at(off(same_axle)), BLACK), line(at(off(ours["path"])), BLUE),
            text(370, 337, "0 s"), text(580, 337, "11 s"), text(345, 367, "red: how far one of its runs spreads"),
            text(345, 384, "black, blue: how far ours is off")]


def curves(law):
    at = lambda column: [(690 + 3500 * row[0], 320 - 100 * math.log10(max(row[column], 10.0) / 10)) for row in law]
    ticks = [text(655, 324 - 100 * math.log10(v / 10), str(v)) for v in (10, 100, 1000)]
    return ["<path d='M690 40V320H920' fill='none' stroke='#888'/>", *ticks, line(at(2), STRONG_RED), line(at(1), BLACK),
            text(655, 25, "ps0 before a body (log.)"), text(690, 337, "gap 0 mm"), text(890, 337, "60 mm"),
            text(655, 367, "red: Enki"), text(655, 384, "black: ours (Webots' law before a red body)")]


main()
