#!/usr/bin/env python3
"""Inputs of a fuzzer as one text file: a line each, in hex, the smallest first.

    fuzz_corpus.py pack DIR... FILE [BYTES]    keeps the smallest inputs of the folders, at most so many bytes in all (65536)
    fuzz_corpus.py unpack FILE DIR             one file for each line, as fuzzers want them
"""

import hashlib
import pathlib
import sys


def pack(folders, file, most):
    inputs = {path.read_bytes() for folder in folders for path in pathlib.Path(folder).iterdir() if path.is_file()}
    kept, total = [], 0
    for data in sorted(inputs, key=lambda data: (len(data), data)):
        total += len(data)
        if data and total <= most:
            kept.append(data.hex())
    pathlib.Path(file).write_text("".join(f"{line}\n" for line in kept))
    print(f"{file}: {len(kept)} of {len(inputs)} inputs")


def unpack(file, folder):
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    for line in pathlib.Path(file).read_text().split():
        data = bytes.fromhex(line)
        (folder / hashlib.sha1(data).hexdigest()).write_bytes(data)


def main():
    what, *rest = sys.argv[1:]
    if what == "unpack":
        unpack(*rest)
        return
    most = int(rest.pop()) if rest[-1].isdigit() else 65536
    pack(rest[:-1], rest[-1], most)


main()
