#!/usr/bin/env python3
"""How fast other simulators and environments are, beside ours, in one go. All figures are per second of processor time.

    python3 tools/yardsticks/run.py [FOLDER]

It installs what it needs: Enki and a renderer (Debian's libenki-dev and libosmesa6, as root), MuJoCo, EnvPool and Gymnasium with Box2D into an environment of
its own in FOLDER (a temporary one if nothing is said), and there `metal_rl` in its release profile. No test needs it.
"""

import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
ROUNDS = 5


def run(*command, **more):
    return subprocess.run(command, check=True, text=True, capture_output=True, cwd=ROOT, **more).stdout


#: Debian packages and a file of each.
PACKAGES = {"libenki-dev": "/usr/include/enki/PhysicalEngine.h", "libosmesa6": "/usr/share/doc/libosmesa6"}


def install():
    """The Debian packages that are missing."""
    missing = [name for name, file in PACKAGES.items() if not Path(file).exists()]
    if missing:
        run("apt-get", "install", "-y", "-qq", "--no-install-recommends", *missing)


def enki(folder):
    """Enki's world of three robots."""
    program = folder / "enki"
    source = ROOT / "tools/yardsticks/enki.cpp"
    run("c++", "-O3", "-march=native", str(source), "-o", str(program), "-lenki")
    return max(float(run(str(program), "100000")) for _ in range(ROUNDS))


def ours():
    """Our world benchmark: microseconds a step by what is looked at."""
    lines = run("cargo", "bench", "--quiet", "--package", "metal-worlds", "--bench", "world").splitlines()
    rows = (line.split("\t") for line in lines)
    return {row[2]: 1 / float(row[3]) for row in rows if len(row) == 5 and row[1] == "world"}


def environment(folder):
    """The Python of an environment that holds all of them."""
    python = folder / "venv/bin/python"
    if not python.exists():
        run(sys.executable, "-m", "venv", str(folder / "venv"))
        run(str(python), "-m", "pip", "install", "--quiet", "maturin", "mujoco", "gymnasium[box2d]", "numpy")
        # Where there is no wheel of it for this Python, its rows are no numbers.
        subprocess.run([str(python), "-m", "pip", "install", "--quiet", "envpool"], check=False)
    variables = {**os.environ, "VIRTUAL_ENV": str(folder / "venv")}
    variables["PATH"] = f"{folder / 'venv/bin'}:{variables['PATH']}"
    run(str(folder / "venv/bin/maturin"), "develop", "--quiet", "--release", env=variables)
    return python


def main():
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else tempfile.mkdtemp()).resolve()
    folder.mkdir(parents=True, exist_ok=True)
    install()
    try:
        rows = {f"ours: {name}": rate for name, rate in ours().items()}
        rows["Enki: three E-pucks, cameras of 60 pixels"] = enki(folder)
        python = environment(folder)
        inside = run(str(python), str(ROOT / "tools/yardsticks/environments.py"), str(ROUNDS))
        # A child's last line: libraries may greet before it.
        rows |= json.loads(inside.splitlines()[-1])
    finally:
        if len(sys.argv) < 2:
            shutil.rmtree(folder, ignore_errors=True)
    print("| what | per second of processor time |\n|---|---:|")
    for what, rate in rows.items():
        print(f"| {what} | {rate:,.0f} |" if rate >= 10 else f"| {what} | {rate:.3f} |")


if __name__ == "__main__":
    main()
