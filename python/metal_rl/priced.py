"""Any Gymnasium environment as a task with priced sensors."""

from __future__ import annotations

import copy
import json
from collections.abc import Callable, Sequence
from typing import Any

import gymnasium as gym
import numpy as np

from metal_rl import _core, actions as motor
from metal_rl.demonstrations import Recording
from metal_rl.errors import refuse
from metal_rl.sensors import Sensor
from metal_rl.tasks import Spec

#: Motor steps of the random drive that finds the range of an unbounded sensor.
CALIBRATION_STEPS = 1000
#: Longest episode that is assumed where the environment names none.
HORIZON = 1000
#: Gymnasium's seeds have 31 bits.
SEEDS = 2**31


class PricedSensors(Spec):
    """A Gymnasium environment whose observation is read in parts, each at a price.

    Nothing of an observation reaches the mind unless the sensor it belongs to is asked and paid; sensors that are
    functions are called only then. `expert` is an advisor for Phase I: a function of the environment that returns the
    index of a motor action; `demonstrations` are recordings of one instead, such as a Minari dataset. `test_env` is where tests happen, if not in `env`.
    """

    def __init__(
        self,
        env: gym.Env,
        sensors: Sequence[Sensor],
        actions: Any = None,
        *,
        expert: Callable[[gym.Env], int] | None = None,
        demonstrations: Any = None,
        test_env: gym.Env | None = None,
        name: str | None = None,
    ) -> None:
        self.env = env
        self.sensors = list(sensors)
        self.expert = expert
        names = [sensor.name for sensor in self.sensors]
        if not names or len(set(names)) != len(names):
            raise refuse("sensors", f"{names}: at least one, and each name once")
        self._actions, self._values = motor.declared(env.action_space, actions)
        self._id = name or (env.spec.id if env.spec else type(env.unwrapped).__name__)
        self._observation: Any = None
        self._bounds = self._ranges()
        self._tests = self if test_env is None else self._elsewhere(test_env)
        watched = self if demonstrations is None else self._recorded(demonstrations)
        self.core = _core.Task.python(self, watched, self._tests)
        json.loads(self.core.spec())

    def world(self, testing: bool = False) -> PythonWorld:
        """The environment, sensor by sensor."""
        return PythonWorld(self._tests if testing else self)

    def _elsewhere(self, env: gym.Env) -> PricedSensors:
        if env.action_space != self.env.action_space or env.observation_space != self.env.observation_space:
            raise refuse("test_env", "has other actions or observations than env")
        other = copy.copy(self)
        other.env, other._observation = env, None
        return other

    def _recorded(self, demonstrations: Any) -> PricedSensors:
        tape = Recording(demonstrations, self.env.observation_space, self.env.action_space)
        other = self._elsewhere(tape)
        other.expert = lambda env: motor.nearest(self._values, env.action)
        return other

    # What Rust calls.

    def _spec(self) -> str:
        sensors = [self._sensor_spec(i) for i in range(len(self.sensors))]
        limit = self.env.spec.max_episode_steps if self.env.spec else None
        contract = {"id": self._id, "sensors": sensors, "actions": self._actions, "measures": []}
        return json.dumps({**contract, "horizon": int(limit or HORIZON)})

    def _sensor_spec(self, index: int) -> dict[str, Any]:
        sensor, (low, high) = self.sensors[index], self._bounds[index]
        rows = zip(low.tolist(), high.tolist())
        features = [{"name": str(i), "low": lo, "high": hi} for i, (lo, hi) in enumerate(rows)]
        if sensor.missing:
            features += [{"name": f"{i}?", "low": 0.0, "high": 1.0} for i in range(len(low))]
        return {"name": sensor.name, "features": features, "price": float(sensor.cost)}

    def _opinions(self) -> list[int]:
        return [i for i, sensor in enumerate(self.sensors) if sensor.opinion]

    def _reset(self, seed: int) -> None:
        self._observation, _ = self.env.reset(seed=seed % SEEDS)

    def _sense(self, index: int) -> np.ndarray:
        sensor = self.sensors[index]
        reading = sensor.read(self.env, self._observation)
        if not sensor.missing:
            return reading
        low, high = self._bounds[index]
        known = ~np.isnan(reading)
        return np.concatenate([np.where(known, reading, (low + high) / 2), known.astype(np.float64)])

    def _step(self, action: int) -> tuple[float, int]:
        self._observation, reward, terminated, truncated, _ = self.env.step(self._values[action])
        return float(reward), 1 if terminated else 2 if truncated else 0

    def _advise(self) -> int | None:
        return None if self.expert is None else int(self.expert(self.env))

    def _fork(self) -> PricedSensors | None:
        """An independent copy, where the environment can be copied."""
        try:
            env = copy.deepcopy(self.env)
        except Exception:  # noqa: BLE001 - whatever an environment cannot copy, it then is not copied
            return None
        other = copy.copy(self)
        other.env, other._observation = env, copy.deepcopy(self._observation)
        return other

    # Ranges.

    def _ranges(self) -> list[tuple[np.ndarray, np.ndarray]]:
        found = [sensor.bounds(self.env.observation_space) for sensor in self.sensors]
        unknown = [i for i, bounds in enumerate(found) if bounds is None]
        if unknown:
            for i, bounds in zip(unknown, self._drive(unknown)):
                found[i] = bounds
        for sensor, bounds in zip(self.sensors, found):
            low, high = bounds
            if low.shape != high.shape or not bool((low < high).all()):
                raise refuse(f"sensors.{sensor.name}", f"range {low} … {high}: low < high, one per number")
        return found

    def _drive(self, unknown: list[int]) -> list[tuple[np.ndarray, np.ndarray]]:
        """Ranges of sensors as a random drive shows them, and as much again on either side."""
        rng, seen = np.random.default_rng(0), [[] for _ in unknown]
        self._reset(0)
        for step in range(CALIBRATION_STEPS):
            for log, i in zip(seen, unknown):
                log.append(self.sensors[i].read(self.env, self._observation))
            if self._step(int(rng.integers(len(self._values))))[1]:
                self._reset(step + 1)
        return [_widened(np.array(log), self.sensors[i].name) for log, i in zip(seen, unknown)]

    def __repr__(self) -> str:
        return f"PricedSensors({self._id}, {', '.join(s.name for s in self.sensors)})"


def _widened(log: np.ndarray, name: str) -> tuple[np.ndarray, np.ndarray]:
    if not np.isfinite(log).any(axis=0).all():
        raise refuse(f"sensors.{name}", "no finite reading in a random drive; give low and high")
    low, high = np.nanmin(log, axis=0), np.nanmax(log, axis=0)
    span = np.where(high > low, high - low, 1.0)
    return low - span / 2, high + span / 2


class PythonWorld:
    """A `PricedSensors` with the methods of a built-in world."""

    def __init__(self, task: PricedSensors) -> None:
        self._task = task

    def reset(self, seed: int) -> None:
        """Begins the episode of `seed`."""
        self._task._reset(seed)

    def sense(self, sensor: int) -> np.ndarray:
        """Reads one sensor."""
        return self._task._sense(sensor)

    def step(self, action: int) -> tuple[float, int]:
        """Carries out a motor action: reward, and 0 (goes on), 1 (over) or 2 (time limit)."""
        return self._task._step(action)

    def advise(self) -> int | None:
        """What the expert would do now."""
        return self._task._advise()
