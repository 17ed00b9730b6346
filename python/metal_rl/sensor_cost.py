"""Consult, then act: the very problem METAL learns, as a Gymnasium environment for anybody's algorithm."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium import spaces

from metal_rl.tasks import Task


class SensorCostEnv(gym.Env[np.ndarray, np.integer]):
    """Actions 0 … m−1 are motor actions, action m+i reads sensor i.

    A look earns minus its price and shows the reading; a motor action earns its reward and forgets every reading, so
    stale ones are never kept. The observation holds all readings scaled to 0 … 1 (0 where nobody looked), then one bit
    per sensor that says whether it was read. Reading a sensor twice in a motor step is allowed but pays again for
    nothing: `action_masks()` (the convention of sb3-contrib's MaskablePPO) is false there, and is to be asked before
    every single action, because it changes with every look.

    Looks take no time in this problem, so whoever is not masked could look for ever and never meet what moves cost.
    The (2n+1)-th look of a motor step at n sensors therefore ends it: it is paid, and motor action 0 is carried out.

    `info`: `consulted` (names read before this motor action), `sensor_cost` (paid for them so far), `motor_reward`
    (what the motor action earned; 0 after a look), `moved` (whether a motor action was carried out).
    """

    metadata = {"render_modes": []}

    def __init__(self, task: Task, *, testing: bool = False) -> None:
        self.task = task
        self._world = task.world(testing)
        sensors = task.spec["sensors"]
        self._names = [sensor["name"] for sensor in sensors]
        self._prices = [float(sensor["price"]) for sensor in sensors]
        self._ranges = [_range(sensor) for sensor in sensors]
        ends = np.cumsum([len(sensor["features"]) for sensor in sensors]).tolist()
        self._places = [slice(a, b) for a, b in zip([0, *ends[:-1]], ends)]
        self.motor_actions = len(task.spec["actions"])
        self.action_space = spaces.Discrete(self.motor_actions + len(sensors))
        self.observation_space = spaces.Box(0.0, 1.0, (ends[-1] + len(sensors),), dtype=np.float32)
        self._most_looks = 2 * len(sensors) + 1
        self._clear()

    def _clear(self) -> None:
        self._readings = np.zeros(self._places[-1].stop, dtype=np.float32)
        self._read = np.zeros(len(self._names), dtype=np.float32)
        self._consulted: list[str] = []
        self._cost = 0.0

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Begins an episode; nothing was read yet."""
        super().reset(seed=seed)
        self._world.reset(int(self.np_random.integers(2**63)))
        self._clear()
        return self._observe(), self._info(0.0, moved=False)

    def step(self, action: np.integer) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        """A look, or a motor action."""
        choice = int(action)
        if choice < self.motor_actions:
            return self._move(choice, paid_now=0.0)
        sensor = choice - self.motor_actions
        self._look(sensor)
        if len(self._consulted) == self._most_looks:
            return self._move(0, paid_now=self._prices[sensor])
        return self._observe(), -self._prices[sensor], False, False, self._info(0.0, moved=False)

    def _move(self, action: int, paid_now: float) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        motor, end = self._world.step(action)
        info = self._info(motor, moved=True)
        self._clear()
        return self._observe(), motor - paid_now, end == 1, end == 2, info

    def _look(self, sensor: int) -> None:
        low, span = self._ranges[sensor]
        scaled = np.clip((self._world.sense(sensor) - low) / span, 0.0, 1.0)
        self._readings[self._places[sensor]] = scaled
        self._read[sensor] = 1.0
        self._consulted.append(self._names[sensor])
        self._cost += self._prices[sensor]

    def action_masks(self) -> np.ndarray:
        """True for motor actions and for sensors not yet read in this motor step."""
        return np.concatenate([np.ones(self.motor_actions, dtype=bool), self._read == 0.0])

    def _observe(self) -> np.ndarray:
        return np.concatenate([self._readings, self._read])

    def _info(self, motor: float, *, moved: bool) -> dict[str, Any]:
        facts = {"consulted": tuple(self._consulted), "sensor_cost": self._cost}
        return {**facts, "motor_reward": motor, "moved": moved}


def _range(sensor: dict[str, Any]) -> tuple[np.ndarray, np.ndarray]:
    low = np.array([feature["low"] for feature in sensor["features"]])
    high = np.array([feature["high"] for feature in sensor["features"]])
    return low, high - low
