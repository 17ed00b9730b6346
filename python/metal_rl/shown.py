"""What a person showed in `metal studio`, or a robot's driver with `metal drive --demonstrate`, as numpy arrays."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from metal_rl.errors import refuse

#: Version of the files that can be read.
VERSION = 1
#: How an episode goes on or ends.
ENDS = ("Running", "Terminal", "TimeLimit")


@dataclass(frozen=True)
class ShownEpisode:
    """One episode of a demonstration, in the layout of Minari's episodes.

    `observations`: sensor → readings in its own unit, one row per moment (steps, or steps + 1 where a last look is
    there). `actions`, `advice` (what the scripted expert would have done, −1: nobody said), `rewards` (motor rewards),
    `accidents`, `terminations` and `truncations`: one entry per step.
    """

    observations: dict[str, np.ndarray]
    actions: np.ndarray
    advice: np.ndarray
    rewards: np.ndarray
    accidents: np.ndarray
    terminations: np.ndarray
    truncations: np.ndarray

    def __len__(self) -> int:
        return len(self.actions)


@dataclass(frozen=True)
class Demonstration:
    """A set of shown episodes. `sensors`: sensor → names of its features; `prices`: sensor → price of a look."""

    environment: str
    sensors: dict[str, list[str]]
    prices: dict[str, float]
    actions: list[str]
    episodes: list[ShownEpisode]

    def __iter__(self) -> Iterator[ShownEpisode]:
        return iter(self.episodes)

    @property
    def steps(self) -> int:
        """Motor steps in all episodes."""
        return sum(len(episode) for episode in self.episodes)


def read_demonstration(path: str | PathLike[str]) -> Demonstration:
    """Reads a file of demonstrations (JSON lines; the format is in the guide of the studio).

    Raises a `MetalError` that names the file, the line and the field of what cannot be read, and `OSError` as `open` does.
    """
    path = Path(path)
    with open(path, encoding="utf-8") as file:
        rows = [_row(path, number, line) for number, line in enumerate(file, 1) if line.strip()]
    if not rows:
        raise refuse(str(path), "empty: the first line says whose demonstrations these are")
    header = rows[0]
    version = header.get("metal_demonstrations")
    if version != VERSION:
        raise refuse(f"{path}, line 1, metal_demonstrations", f"{version!r}: this package reads version {VERSION}")
    sensors = {s["name"]: s for s in header.get("sensors", []) if isinstance(s, dict) and "name" in s}
    if not sensors:
        raise refuse(f"{path}, line 1, sensors", "none")
    moments = [_Moment(path, number, row, header, sensors) for number, row in enumerate(rows[1:], 2)]
    return Demonstration(
        environment=str(header.get("environment", "")),
        sensors={name: [f["name"] for f in s["features"]] for name, s in sensors.items()},
        prices={name: float(s.get("price", 0.0)) for name, s in sensors.items()},
        actions=[str(action) for action in header.get("actions", [])],
        episodes=[_episode(list(sensors), part) for part in _by_episode(moments) if any(m.acted for m in part)],
    )


def _row(path: Path, number: int, line: str) -> dict[str, Any]:
    try:
        row = json.loads(line)
    except json.JSONDecodeError as error:
        raise refuse(f"{path}, line {number}", f"no JSON: {error.msg}") from None
    if not isinstance(row, dict):
        raise refuse(f"{path}, line {number}", "no JSON object")
    return row


class _Moment:
    """One line after the first, checked."""

    def __init__(
        self, path: Path, number: int, row: Mapping[str, Any], header: Mapping[str, Any], sensors: Mapping[str, Any]
    ) -> None:
        def field(name: str, kind: type | tuple[type, ...], default: Any = None) -> Any:
            value = row.get(name, default)
            if not isinstance(value, kind) or isinstance(value, bool) and kind is not bool:
                raise refuse(f"{path}, line {number}, {name}", f"{value!r}")
            return value

        self.episode = field("episode", int)
        readings = field("readings", list)
        widths = [len(s["features"]) for s in sensors.values()]
        try:
            self.readings = [np.asarray(reading, dtype=float) for reading in readings]
        except (TypeError, ValueError):
            raise refuse(f"{path}, line {number}, readings", "numbers are wanted") from None
        if [reading.shape for reading in self.readings] != [(width,) for width in widths]:
            raise refuse(f"{path}, line {number}, readings", f"lengths {widths} are wanted, one per sensor")
        self.acted = row.get("action") is not None
        choices = len(header.get("actions", []))
        self.action = field("action", int) if self.acted else -1
        if self.acted and not 0 <= self.action < choices:
            raise refuse(f"{path}, line {number}, action", f"{self.action}: there are {choices} actions")
        self.advice = -1 if row.get("advice") is None else field("advice", int)
        self.reward = float(field("motor_reward", (int, float), 0.0))
        self.accident = field("accident", bool, False)
        self.end = field("end", str, "Running")
        if self.end not in ENDS:
            raise refuse(f"{path}, line {number}, end", f"{self.end!r}; known: {', '.join(ENDS)}")


def _by_episode(moments: list[_Moment]) -> list[list[_Moment]]:
    parts: list[list[_Moment]] = []
    for moment in moments:
        if not parts or parts[-1][0].episode != moment.episode:
            parts.append([])
        parts[-1].append(moment)
    return parts


def _episode(names: list[str], moments: list[_Moment]) -> ShownEpisode:
    acted = [m for m in moments if m.acted]
    last = acted[-1]
    ended = np.zeros(len(acted), dtype=bool)
    ended[-1] = last.end == "Terminal"
    cut = np.zeros(len(acted), dtype=bool)
    cut[-1] = not ended[-1]
    return ShownEpisode(
        observations={name: np.stack([m.readings[i] for m in moments]) for i, name in enumerate(names)},
        actions=np.array([m.action for m in acted]),
        advice=np.array([m.advice for m in acted]),
        rewards=np.array([m.reward for m in acted]),
        accidents=np.array([m.accident for m in acted]),
        terminations=ended,
        truncations=cut,
    )
