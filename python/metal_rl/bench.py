"""Does attention pay on this task? Blind, subsets, all sensors, fusion and METAL with equal budgets."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any

from metal_rl import _core
from metal_rl.errors import refuse
from metal_rl.minds import recipe_of
from metal_rl.tasks import Task


@dataclass(frozen=True)
class Bench:
    """The comparison; `print(bench)` shows it."""

    #: Everything, as `metal bench --json` writes it.
    results: dict[str, Any]
    #: Table, front and histogram.
    text: str

    @property
    def warnings(self) -> list[str]:
        """What to know before believing anything."""
        return list(self.results["warnings"])

    def total(self, row: str) -> tuple[float, float | None, float | None]:
        """Reward minus cost per episode of a row: interquartile mean and its 95 % interval."""
        estimate = self.results["rows"][row]["total"]
        return estimate["mean"], estimate["lo"], estimate["hi"]

    def looks(self, row: str) -> float:
        """Sensors read per motor step."""
        return self.results["rows"][row]["looks"]["mean"]

    def frame(self) -> Any:
        """Every test episode of every training as a pandas DataFrame (needs `pip install metal-rl[tables]`)."""
        import pandas as pd

        parts = [
            pd.DataFrame(
                {
                    "task": self.results["task"],
                    "row": row,
                    "training": training,
                    "episode": range(len(score["motor"])),
                    "motor_reward": score["motor"],
                    "sensor_cost": score["price"],
                    "steps": score["steps"],
                }
            )
            for row, found in self.results["rows"].items()
            for training, score in enumerate(found["scores"])
        ]
        return pd.concat(parts, ignore_index=True)

    def save(self, path: str | PathLike[str]) -> None:
        """Writes `frame()` to a `.parquet` or `.csv` file."""
        place = Path(path)
        if place.suffix not in (".parquet", ".csv"):
            raise refuse("path", f"{place}: must end in .parquet or .csv")
        frame = self.frame()
        if place.suffix == ".parquet":
            frame.to_parquet(place, index=False)
        else:
            frame.to_csv(place, index=False)

    def __str__(self) -> str:
        return self.text


def bench(
    task: Task,
    *,
    steps: int | None = None,
    phases: Mapping[str, int] | Sequence[str] | None = None,
    recipe: Mapping[str, Any] | None = None,
    seeds: int = 5,
    seed: int = 1,
    episodes: int = 100,
    **options: Any,
) -> Bench:
    """Trains and tests everybody on `task`; arguments as for `learn`.

    `options`: `exhaustive` (up to this many sensors every subset is screened, at most 12; beyond, the best subset
    grows greedily), `screening_share` (of the budget), `price_factors` (further prices for the front).
    """
    chosen = json.dumps({"seeds": seeds, "seed": seed, "episodes": episodes, **options})
    results, text = _core.bench(task.core, recipe_of(steps, phases, recipe), chosen)
    return Bench(json.loads(results), text)
