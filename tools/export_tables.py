#!/usr/bin/env python3
"""Writes the tables of scikit-learn that docs/results/bench.md compares on: `export_tables.py FOLDER`."""

import sys
from pathlib import Path

from sklearn import datasets

TABLES = {"breast_cancer": datasets.load_breast_cancer, "wine": datasets.load_wine}


def export(folder: Path) -> None:
    """One CSV per table; the class is the column `class`."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, load in TABLES.items():
        table = load(as_frame=True)
        named = table.data.assign(**{"class": [str(table.target_names[label]) for label in table.target]})
        named.to_csv(folder / f"{name}.csv", index=False)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    export(Path(sys.argv[1]))
