"""Builds the program twice from nothing, in two folders: how long that takes, how large it is, and whether both are the same bytes.

python3 tools/build_facts.py [--crate metal-cli] [--folder /tmp/metal-build]

Prints a table in Markdown. Paths of the machine are taken out of the program (--remap-path-prefix), as they must be
for two folders, or two machines, to give the same bytes. Fails if they do not.
"""

import argparse
import hashlib
import os
import pathlib
import shutil
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent


def flags(target: pathlib.Path) -> str:
    """Compiler flags under which neither the home, nor the sources' folder, nor the target's leaves a trace."""
    cargo_home = os.environ.get("CARGO_HOME", str(pathlib.Path.home() / ".cargo"))
    places = [(str(target), "/target"), (str(ROOT), "/source"), (cargo_home, "/cargo")]
    return " ".join(f"--remap-path-prefix={place}={name}" for place, name in places)


def build(crate: str, target: pathlib.Path) -> float:
    """Seconds of one release build into `target`."""
    environment = os.environ | {"CARGO_TARGET_DIR": str(target), "RUSTFLAGS": flags(target)}
    begin = time.monotonic()
    command = ["cargo", "build", "--locked", "--release", "--quiet", "--package", crate]
    subprocess.run(command, cwd=ROOT, env=environment, check=True)
    return time.monotonic() - begin


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--crate", default="metal-cli")
    parser.add_argument("--binary", default="metal")
    parser.add_argument("--folder", type=pathlib.Path, default=pathlib.Path("/tmp/metal-build"))
    options = parser.parse_args()
    if options.folder.exists():
        print(f"{options.folder} exists; name another --folder", file=sys.stderr)
        return 2
    try:
        return measure(options)
    finally:
        shutil.rmtree(options.folder, ignore_errors=True)


def measure(options: argparse.Namespace) -> int:
    """Builds twice and prints the table."""
    first, second = options.folder / "first", options.folder / "the-second"
    seconds = [build(options.crate, first)]
    (ROOT / "crates" / options.crate / "src" / "main.rs").touch()
    seconds.append(build(options.crate, first))
    seconds.append(build(options.crate, second))
    programs = [(target / "release" / options.binary).read_bytes() for target in (first, second)]
    hashes = [hashlib.sha256(program).hexdigest() for program in programs]
    same = hashes[0] == hashes[1]
    print("| what | figure |\n|---|---:|")
    print(f"| release build from nothing | {seconds[0]:.0f} s |")
    print(f"| the same, into another folder | {seconds[2]:.0f} s |")
    print(f"| after a change of `main.rs` | {seconds[1]:.0f} s |")
    print(f"| size of `{options.binary}` | {len(programs[0]) / 2**20:.1f} MiB |")
    print(f"| SHA-256 | {hashes[0][:16]}… {'and the same' if same else 'against ' + hashes[1][:16] + '…'} |")
    return 0 if same else 1


if __name__ == "__main__":
    sys.exit(main())
