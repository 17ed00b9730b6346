"""Classification with features that cost, from a DataFrame, a CSV or Parquet file, or arrays."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from metal_rl import _core
from metal_rl.errors import refuse
from metal_rl.tasks import Spec


class Table(Spec):
    """Rows with a class; before naming it, one may buy columns.

    `prices`: price of single columns by name. `groups`: columns bought together, as name → (columns, price). All
    other columns cost `default_price`. `right` and `wrong` are what naming the class earns. A share of the rows
    (`test_share`, split by `split_seed`) is kept for tests. Missing values (None, NaN) stay missing: they are told
    apart from every number.
    """

    def __init__(
        self,
        frame: Any,
        target: str,
        *,
        prices: Mapping[str, float] | None = None,
        groups: Mapping[str, tuple[Sequence[str], float]] | None = None,
        default_price: float = 0.02,
        right: float = 0.0,
        wrong: float = -1.0,
        test_share: float = 0.25,
        split_seed: int = 1,
        name: str = "table",
    ) -> None:
        names = [str(column) for column in frame.columns]
        if target not in names:
            raise refuse("target", f"no column {target!r}; known: {', '.join(names)}")
        raw = {
            "name": name,
            "columns": [(c, _cells(frame[c])) for c in names if c != target],
            "target": _cells(frame[target]),
        }
        bought = {n: {"columns": list(cols), "price": float(p)} for n, (cols, p) in (groups or {}).items()}
        for column, price in (prices or {}).items():
            bought[column] = {"columns": [column], "price": float(price)}
        table = {
            "default": default_price,
            "group": bought,
            "verdict": {"right": right, "wrong": wrong},
            "test_share": test_share,
            "split_seed": split_seed,
        }
        self.name = name
        self.core = _core.Task.table(json.dumps(raw), json.dumps(table))

    def world(self, testing: bool = False) -> _core.World:
        """A world of its own."""
        return _core.World(self.core, testing)

    def __repr__(self) -> str:
        return f"Table({self.name!r}, {len(self.spec['sensors'])} groups of columns)"


def read(path: str | PathLike[str], target: str, **options: Any) -> Table:
    """The task of a CSV or Parquet file (needs pandas: `pip install metal-rl[tables]`)."""
    import pandas as pd

    path = Path(path)
    frame = pd.read_parquet(path) if path.suffix == ".parquet" else pd.read_csv(path)
    return Table(frame, target, name=path.stem, **options)


def from_arrays(x: Any, y: Any, names: Sequence[str] | None = None, **options: Any) -> Table:
    """The task of a matrix of features and a vector of classes, as scikit-learn's data sets come."""
    x, y = np.asarray(x), np.asarray(y)
    if x.ndim != 2 or y.shape != (len(x),):
        raise refuse("x", f"shapes {x.shape} and {y.shape}: a matrix, and one class per row")
    names = [f"x{i}" for i in range(x.shape[1])] if names is None else [str(n) for n in names]
    return Table(_Columns({**dict(zip(names, x.T)), "target": y}), "target", **options)


class _Columns(dict):
    """As much of a DataFrame as `Table` needs."""

    @property
    def columns(self) -> list[str]:
        return list(self)


def _cells(column: Any) -> list[Any]:
    return [_cell(value) for value in np.asarray(column, dtype=object)]


def _cell(value: Any) -> Any:
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, bool):
        return float(value)
    if isinstance(value, (int, float)):
        return float(value) if math.isfinite(value) else None
    if isinstance(value, str):
        return value
    # None, and whatever else a frame library writes where nobody knows (NaT, NA).
    return None
