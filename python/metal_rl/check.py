"""Is a task well posed? What it costs to be blind, what each sensor tells, how prices and rewards compare."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

from metal_rl import _core
from metal_rl.tasks import Task


@dataclass(frozen=True)
class Check:
    """The findings; `print(check)` shows them."""

    #: Everything, as `metal check --json` writes it.
    results: dict[str, Any]
    #: The findings as text.
    text: str

    @property
    def blind(self) -> dict[str, float]:
        """Mean motor reward per episode of every constant action."""
        return {constant["action"]: constant["motor"] for constant in self.results["blind"]}

    @property
    def everything(self) -> float:
        """Mean motor reward per episode with all sensors."""
        return float(self.results["everything"])

    @property
    def alone(self) -> dict[str, float]:
        """Mean motor reward per episode with one sensor only."""
        return {sensor["name"]: sensor["alone"] for sensor in self.results["sensors"]}

    @property
    def bits(self) -> dict[str, float]:
        """Entropy of every sensor's readings."""
        return {sensor["name"]: sensor["bits"] for sensor in self.results["sensors"]}

    @property
    def problems(self) -> list[str]:
        """What is badly posed, for certain."""
        return list(self.results["problems"])

    @property
    def warnings(self) -> list[str]:
        """What is perhaps badly posed, as far as those who learned so briefly can tell."""
        return list(self.results["warnings"])

    def __str__(self) -> str:
        return self.text


def check(task: Task, *, steps: int = 3000, episodes: int = 50, seed: int = 1) -> Check:
    """Drives `task` blindly and at random, and learns it once with every sensor alone and once with all.

    `steps`: motor steps from which everybody who sees something learns; `episodes`: of every drive.
    """
    options = json.dumps({"seed": seed, "episodes": episodes, "steps": steps})
    results, text = _core.check(task.core, options)
    return Check(json.loads(results), text)
