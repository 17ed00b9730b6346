"""Writes the bill of materials of the program (CycloneDX 1.5, JSON): every package that `metal` is built from.

python3 tools/sbom.py [--package metal-cli] > metal.cdx.json

Names, versions and licences come from `cargo metadata --locked`, checksums from Cargo.lock. Packages for tests alone and
packages for other platforms are left out. The same sources give the same bytes: no time, no random number.
"""

import argparse
import json
import pathlib
import subprocess
import sys
import tomllib

ROOT = pathlib.Path(__file__).resolve().parent.parent


def metadata() -> dict:
    """What cargo knows of all packages, for the platform of this machine."""
    version = subprocess.run(["rustc", "-vV"], check=True, capture_output=True, text=True).stdout
    host = next(line.split()[1] for line in version.splitlines() if line.startswith("host:"))
    command = ["cargo", "metadata", "--format-version", "1", "--locked", "--filter-platform", host]
    return json.loads(subprocess.run(command, cwd=ROOT, check=True, capture_output=True).stdout)


def reached(graph: dict, root: str) -> dict[str, list[str]]:
    """Packages that `root` needs to be built or to run, each with those that it needs itself."""
    nodes = {node["id"]: node for node in graph["resolve"]["nodes"]}
    found, waiting = {}, [root]
    while waiting:
        package = waiting.pop()
        if package not in found:
            needs = nodes[package]["deps"]
            found[package] = sorted(n["pkg"] for n in needs if any(k["kind"] != "dev" for k in n["dep_kinds"]))
            waiting += found[package]
    return found


def purl(package: dict) -> str:
    return f"pkg:cargo/{package['name']}@{package['version']}"


def component(package: dict, checksums: dict) -> dict:
    """One package in the words of CycloneDX."""
    entry = {"type": "library", "bom-ref": purl(package), "name": package["name"], "version": package["version"]}
    entry["purl"] = purl(package)
    if package["license"]:
        entry["licenses"] = [{"expression": package["license"].replace("/", " OR ")}]
    if checksum := checksums.get((package["name"], package["version"])):
        entry["hashes"] = [{"alg": "SHA-256", "content": checksum}]
    return entry


def bill(graph: dict, name: str) -> dict:
    packages = {package["id"]: package for package in graph["packages"]}
    locked = tomllib.loads((ROOT / "Cargo.lock").read_text())["package"]
    checksums = {(p["name"], p["version"]): p.get("checksum") for p in locked}
    root = next(p["id"] for p in graph["packages"] if p["name"] == name and p["source"] is None)
    needs = reached(graph, root)
    parts = sorted((packages[i] for i in needs if i != root), key=purl)
    program = component(packages[root], checksums) | {"type": "application"}
    edges = [{"ref": purl(packages[i]), "dependsOn": sorted({purl(packages[n]) for n in needs[i]})} for i in needs]
    return {
        "bomFormat": "CycloneDX",
        "specVersion": "1.5",
        "version": 1,
        "metadata": {"component": program},
        "components": [component(part, checksums) for part in parts],
        "dependencies": sorted(edges, key=lambda edge: edge["ref"]),
    }


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--package", default="metal-cli")
    json.dump(bill(metadata(), parser.parse_args().package), sys.stdout, indent=1)
    print()
    return 0


if __name__ == "__main__":
    sys.exit(main())
