"""What a task is: sensors with prices, motor actions, and a world to act in."""

from __future__ import annotations

import json
from functools import cached_property
from typing import Any, Protocol, runtime_checkable

import numpy as np

from metal_rl import _core


@runtime_checkable
class Task(Protocol):
    """Whatever `learn`, `bench` and `SensorCostEnv` take: `PricedSensors`, `BuiltIn`, `tabular.Table`."""

    @property
    def core(self) -> _core.Task:
        """The task as Rust holds it."""

    @property
    def spec(self) -> dict[str, Any]:
        """Sensors with features and prices, actions, horizon."""

    def world(self, testing: bool = False) -> Any:
        """A world with `reset(seed)`, `sense(i)`, `step(a)`, `advise()`."""


class Spec:
    """What follows from a task's contract."""

    core: _core.Task

    @cached_property
    def spec(self) -> dict[str, Any]:
        """The contract: `sensors` (name, features, price), `actions`, `horizon`, `id`."""
        return json.loads(self.core.spec())

    @property
    def sensor_names(self) -> list[str]:
        """Names of the sensors, in order."""
        return [sensor["name"] for sensor in self.spec["sensors"]]

    @property
    def action_names(self) -> list[str]:
        """Names of the motor actions, in order."""
        return list(self.spec["actions"])

    @property
    def prices(self) -> np.ndarray:
        """Price of one look at each sensor."""
        return np.array([sensor["price"] for sensor in self.spec["sensors"]])


class BuiltIn(Spec):
    """A task that comes with the library, by the name `metal bench` uses: `highway`, `maze`, `puddle`, `toy`, …

    Settings are those of the environment in an experiment file, e.g. `BuiltIn("maze", side=6, look_price=0.05)`.
    """

    def __init__(self, name: str, **settings: Any) -> None:
        self.name = name
        self.core = _core.Task.named(name, json.dumps(settings))

    def world(self, testing: bool = False) -> _core.World:
        """A world of its own."""
        return _core.World(self.core, testing)

    def __repr__(self) -> str:
        return f"BuiltIn({self.name!r})"
