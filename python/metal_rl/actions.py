"""Motor actions: a METAL task has finitely many, so boxes are cut into values that somebody declares."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from gymnasium import spaces

from metal_rl.errors import refuse

#: Most motor actions beside one sensor: looks and moves are numbered together.
MOST = 63


@dataclass(frozen=True)
class Grid:
    """`per_dimension` equally spaced values of every dimension of a box, ends included."""

    per_dimension: int


def declared(space: spaces.Space, actions: Any) -> tuple[list[str], list[Any]]:
    """Names and values of the motor actions of `space`, as `actions` declares them."""
    if isinstance(actions, Mapping):
        names, values = [str(name) for name in actions], list(actions.values())
    else:
        values = list(_values(space, actions))
        names = [_name(value) for value in values]
    for name, value in zip(names, values):
        if not space.contains(value):
            raise refuse(f"actions.{name}", f"{value!r} is not in {space}")
    if not 1 <= len(values) <= MOST:
        raise refuse("actions", f"{len(values)}: between 1 and {MOST}; declare fewer")
    return names, values


def _values(space: spaces.Space, actions: Any) -> Sequence[Any]:
    if isinstance(actions, Grid):
        return _grid(space, actions.per_dimension)
    if actions is not None:
        return [_as_element(space, value) for value in actions]
    if isinstance(space, spaces.Discrete):
        return [int(space.start) + i for i in range(int(space.n))]
    if isinstance(space, spaces.MultiDiscrete) and int(np.prod(space.nvec)) <= MOST:
        product = itertools.product(*(range(int(n)) for n in space.nvec.ravel()))
        return [np.array(v, dtype=space.dtype).reshape(space.shape) for v in product]
    if isinstance(space, spaces.MultiBinary) and 2**space.shape[0] <= MOST:
        return [np.array(v, dtype=space.dtype) for v in itertools.product((0, 1), repeat=space.shape[0])]
    raise refuse("actions", f"{space} has no finite list of actions: give values, or Grid(n) for a box")


def _grid(space: spaces.Space, count: int) -> Sequence[Any]:
    if not isinstance(space, spaces.Box) or not space.is_bounded():
        raise refuse("actions", f"Grid needs a bounded box, not {space}")
    if count < 2:
        raise refuse("actions", f"Grid({count}): at least 2 values per dimension")
    if count ** int(np.prod(space.shape)) > MOST:
        raise refuse("actions", f"Grid({count}) over shape {space.shape} makes more than {MOST} actions")
    lows, highs = space.low.ravel(), space.high.ravel()
    axes = [np.linspace(low, high, count) for low, high in zip(lows, highs)]
    return [_as_element(space, np.array(v)) for v in itertools.product(*axes)]


def _as_element(space: spaces.Space, value: Any) -> Any:
    if isinstance(space, spaces.Discrete):
        return int(value)
    return np.asarray(value, dtype=space.dtype).reshape(space.shape)


def _name(value: Any) -> str:
    if isinstance(value, np.ndarray):
        return "[" + " ".join(f"{x:g}" for x in value.ravel()) + "]"
    return str(value)


def nearest(values: Sequence[Any], action: Any) -> int:
    """Index of the declared value that is nearest to `action`."""
    target = np.asarray(action, dtype=np.float64)
    distances = [np.abs(np.asarray(value, dtype=np.float64) - target).sum() for value in values]
    return int(np.argmin(distances))
