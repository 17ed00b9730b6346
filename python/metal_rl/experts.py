"""Experts of every kind as sensors: what they read of the world is an opinion, and asking has a price."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from metal_rl.errors import refuse
from metal_rl.sensors import Sensor


def Expert(  # noqa: N802 - it is used like the class it makes
    name: str,
    mind: Any,
    reads: Callable[[Any], ArrayLike],
    actions: int,
    cost: float = 0.0,
    *,
    learning: bool = False,
    classes: list[int] | None = None,
) -> Sensor:
    """A sensor that is an expert's degree of support for each of `actions` motor actions.

    `mind` is anything with `predict_proba` (scikit-learn), anything with `predict(observation)` that returns
    (action, state) as policies of Stable-Baselines3 do, or a function from what it `reads` to an action's index or to
    one number per action: a hand rule, a trained network, a person at a keyboard. `reads` takes the environment and
    returns what the expert sees; nobody calls it unless the expert is consulted. `classes`: for each class of
    `predict_proba` the motor action it stands for (default: its own label).

    A frozen expert is believed as it is. With `learning=True` a tiny agent learns what the opinion is worth.
    """
    if actions < 1:
        raise refuse(f"experts.{name}.actions", f"{actions}: at least 1")

    def opinion(env: Any) -> np.ndarray:
        return as_support(_ask(mind, np.asarray(reads(env)), classes, actions), actions, name)

    low, high = np.zeros(actions), np.ones(actions)
    return Sensor(name, opinion, cost, low, high, opinion=not learning)


def _ask(mind: Any, seen: np.ndarray, classes: list[int] | None, actions: int) -> Any:
    if hasattr(mind, "predict_proba"):
        shares = np.asarray(mind.predict_proba(seen.reshape(1, -1)))[0]
        places = classes if classes is not None else [int(c) for c in mind.classes_]
        support = np.zeros(actions)
        support[places] = shares
        return support
    if hasattr(mind, "predict"):
        answer = mind.predict(seen)
        return answer[0] if isinstance(answer, tuple) else answer
    return mind(seen)


def as_support(answer: Any, actions: int, name: str) -> np.ndarray:
    """An action's index, or one number per action, as shares that sum to 1."""
    values = np.asarray(answer, dtype=np.float64)
    if values.size == 1:
        action = int(values.ravel()[0])
        if not 0 <= action < actions:
            raise refuse(f"experts.{name}", f"says action {action}: 0 to {actions - 1}")
        return np.eye(actions)[action]
    if values.size != actions or not np.isfinite(values).all() or bool((values < 0).any()):
        raise refuse(f"experts.{name}", f"says {answer!r}: {actions} shares, or the index of an action")
    total = values.sum()
    return values.ravel() / total if total > 0 else np.full(actions, 1 / actions)
