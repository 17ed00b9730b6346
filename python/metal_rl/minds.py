"""Learning, and what was learned."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from metal_rl import _core
from metal_rl.errors import refuse
from metal_rl.tasks import Task

#: The phases of the paper and the full observer's own, in their order.
PHASES = ("demonstration", "foa", "fusion", "attention")
#: Motor steps of learning where nothing else is said.
STEPS = 60_000
#: Most bytes of a file's head, which holds the card.
MOST_OF_A_HEAD = 100_000_000


def recipe_of(
    steps: int | None,
    phases: Mapping[str, int] | Sequence[str] | None,
    recipe: Mapping[str, Any] | None,
) -> str:
    """The recipe in JSON: defaults for `steps`, then `phases`, then single fields."""
    whole = json.loads(_core.default_recipe(STEPS if steps is None else steps))
    if phases is not None and not isinstance(phases, Mapping):
        if "fusion" in phases:
            whole["fusion"] = whole["attention"] // 3
            whole["attention"] -= whole["fusion"]
        phases = {name: 0 for name in PHASES if name not in phases} | {n: whole.get(n, 0) for n in phases}
    for name, budget in (phases or {}).items():
        if name not in PHASES:
            raise refuse("phases", f"unknown phase {name!r}; known: {', '.join(PHASES)}")
        whole[name] = int(budget)
    unknown = set(recipe or {}) - set(whole)
    if unknown:
        raise refuse(f"recipe.{sorted(unknown)[0]}", f"unknown field; known: {', '.join(whole)}")
    return json.dumps({**whole, **(recipe or {})})


def learn(
    task: Task,
    *,
    steps: int | None = None,
    phases: Mapping[str, int] | Sequence[str] | None = None,
    seed: int = 1,
    recipe: Mapping[str, Any] | None = None,
) -> Mind:
    """Learns `task`: demonstration (if there is an expert), fusion of all sensors' agents, then attention control.

    `steps`: motor steps altogether (default 60,000). A third of them are fusion's where attention is learned from what agents
    support, none where it is learned from readings, as by default. `phases`: steps of single phases, e.g. `{"fusion": 5000,
    "attention": 20000}`, or the names of those that take place. `recipe`: single fields of the recipe, such as
    `{"credit": {"gamma": 0.9, "lambda": 0.7}}`. The same seed gives the same mind, bit for bit.
    """
    return Mind(_core.learn(task.core, recipe_of(steps, phases, recipe), seed))


def load(path: str | PathLike[str]) -> Mind:
    """A mind that `Mind.save` wrote. It needs neither the task nor its environment to act."""
    return Mind(_core.load(path))


def card(path: str | PathLike[str]) -> dict[str, Any]:
    """What a file says of its mind: recipe, seed, task, version and git revision of the program, notes; nothing is loaded."""
    with open(path, "rb") as file:
        length = int.from_bytes(file.read(8), "little")
        # Damaged files may claim any length.
        head = file.read(min(length, MOST_OF_A_HEAD))
    try:
        return json.loads(json.loads(head)["__metadata__"]["metal"])
    except (ValueError, KeyError, TypeError):
        raise refuse("path", f"{path}: no card of a mind in it") from None


@dataclass(frozen=True)
class Decision:
    """One decision: the motor action, and whom it took to decide."""

    #: Index of the motor action.
    action: int
    #: Name of the motor action.
    name: str
    #: Names of the sensors read, in order.
    consulted: tuple[str, ...]
    #: Price of the looks.
    cost: float


@dataclass(frozen=True)
class Score:
    """A test: one entry per episode; `looks[k]` counts motor steps with k sensors read, `sensors` reads per sensor."""

    motor: np.ndarray
    price: np.ndarray
    steps: np.ndarray
    looks: np.ndarray
    sensors: dict[str, int]

    @property
    def total(self) -> float:
        """Mean over episodes of motor reward minus the price of looking."""
        return float((self.motor - self.price).mean())

    @property
    def looks_per_step(self) -> float:
        """Mean number of sensors read before a motor action."""
        return float((self.looks * np.arange(len(self.looks))).sum() / max(1, self.steps.sum()))

    def summary(self) -> dict[str, float]:
        """Means per episode, looks per motor step, and how many episodes that was."""
        reward, cost = float(self.motor.mean()), float(self.price.mean())
        means = {"total": self.total, "reward": reward, "cost": cost, "looks_per_step": self.looks_per_step}
        return {**means, "episodes": len(self.motor)}


class Mind:
    """What was learned: it decides, asking one sensor after the other."""

    def __init__(self, core: _core.Mind) -> None:
        self._core = core
        self.spec: dict[str, Any] = json.loads(core.spec())
        self.recipe: dict[str, Any] = json.loads(core.recipe())
        self.seed = core.seed
        self.notes = core.notes

    def act(self, reader: Callable[[str], ArrayLike]) -> Decision:
        """Decides; `reader(name)` is called for exactly the sensors the mind asks for, in its order."""
        action, order, cost = self._core.act(reader)
        names = tuple(self.spec["sensors"][i]["name"] for i in order)
        return Decision(action, self.spec["actions"][action], names, cost)

    def evaluate(self, task: Task, episodes: int = 100, seed: int = 0, driver: str = "METAL") -> Score:
        """Greedy test on `task`. `driver`: METAL, all sensors, fusion or expert."""
        score = json.loads(self._core.evaluate(task.core, driver, (episodes, seed)))
        names = [sensor["name"] for sensor in self.spec["sensors"]]
        sensors = dict(zip(names, score.pop("sensors")))
        return Score(**{key: np.array(value) for key, value in score.items()}, sensors=sensors)

    def save(self, path: str | PathLike[str], score: Score | None = None, **notes: Any) -> None:
        """Writes the mind as safetensors with a JSON card; the numbers of a test and `notes` are kept with it."""
        numbers = {} if score is None else score.summary()
        self._core.save(path, {key: str(value) for key, value in {**numbers, **notes}.items()})

    def __repr__(self) -> str:
        return f"Mind({self.spec['id']}, seed {self.seed})"
