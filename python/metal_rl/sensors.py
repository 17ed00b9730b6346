"""Sensors: parts of an observation, or functions that are called only when somebody asks."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import ArrayLike

from metal_rl.errors import refuse

#: What a sensor reads: indices of a flat observation, an index into an image or a nested observation, a dictionary's
#: key, or a function of the environment.
Source = "slice | int | Sequence[int] | tuple[Any, ...] | str | Callable[[Any], ArrayLike]"


@dataclass(frozen=True)
class Sensor:
    """A sensor with a price.

    `source`: a slice, index or list of indices of the observation; a tuple of slices (a region of an image); a key of
    a dictionary observation; or a function of the environment, which is called only when the sensor is asked.
    `feature` turns what was read into the numbers that are learned from (an image region into a colour share, say).
    `low` and `high` are the range of those numbers; where they are not given they come from the observation space, or
    from a short random drive where the space is unbounded. With `missing=True` a reading may be NaN (nobody knows):
    it is told apart from every number by a bit of its own.
    """

    name: str
    source: Any
    cost: float = 0.0
    low: ArrayLike | None = None
    high: ArrayLike | None = None
    feature: Callable[[Any], ArrayLike] | None = None
    missing: bool = False
    #: Whether the reading is an expert's degree of support for every motor action.
    opinion: bool = field(default=False, kw_only=True)

    def __post_init__(self) -> None:
        if not self.name or not isinstance(self.name, str):
            raise refuse("sensors.name", f"{self.name!r}: a word")
        if not (np.isfinite(self.cost) and self.cost >= 0):
            raise refuse(f"sensors.{self.name}.cost", f"{self.cost}: finite and at least 0")

    def read(self, env: Any, observation: Any) -> np.ndarray:
        """What the sensor says now, as a flat array of floats."""
        raw = self.source(env) if callable(self.source) else part(observation, self.source, self.name)
        value = raw if self.feature is None else self.feature(raw)
        return np.asarray(value, dtype=np.float64).ravel()

    def bounds(self, space: spaces.Space) -> tuple[np.ndarray, np.ndarray] | None:
        """The declared range, or that of the observation space; nothing where neither is known."""
        if self.low is not None and self.high is not None:
            return _flat(self.low), _flat(self.high)
        if callable(self.source) or self.feature is not None:
            return None
        found = _box(space, self.source, self.name)
        if found is None:
            return None
        low, high = found
        finite = np.isfinite(low) & np.isfinite(high) & (np.abs(low) < 1e30) & (np.abs(high) < 1e30)
        return (low, high) if bool(finite.all()) else None


def part(observation: Any, source: Any, name: str) -> Any:
    """The part of an observation that `source` names."""
    try:
        if isinstance(observation, dict):
            return observation[source]
        array = np.asarray(observation)
        return array[source if isinstance(source, (slice, int, tuple)) else list(source)]
    except (KeyError, IndexError, TypeError) as error:
        raise refuse(f"sensors.{name}.source", f"{source!r} is not in the observation ({error})") from error


def _flat(value: ArrayLike) -> np.ndarray:
    return np.atleast_1d(np.asarray(value, dtype=np.float64)).ravel()


def _box(space: spaces.Space, source: Any, name: str) -> tuple[np.ndarray, np.ndarray] | None:
    if isinstance(space, spaces.Dict):
        if source not in space.spaces:
            raise refuse(f"sensors.{name}.source", f"{source!r}: keys are {', '.join(space.spaces)}")
        return _whole(space.spaces[source])
    if isinstance(space, spaces.Box):
        return _flat(part(space.low, source, name)), _flat(part(space.high, source, name))
    return None


def _whole(space: spaces.Space) -> tuple[np.ndarray, np.ndarray] | None:
    if isinstance(space, spaces.Box):
        return _flat(space.low), _flat(space.high)
    if isinstance(space, spaces.Discrete):
        return _flat(space.start), _flat(space.start + space.n - 1)
    return None
