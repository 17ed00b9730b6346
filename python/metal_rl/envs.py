"""The built-in worlds as Gymnasium environments: everything is read before every action."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium import spaces
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from metal_rl import _core
from metal_rl.tasks import BuiltIn, Spec

#: Seeds of episodes are drawn from this many bits.
SEED_BITS = 63


def observation_space(spec: dict[str, Any]) -> spaces.Box:
    """All readings, one sensor after the other, in their own units."""
    features = [feature for sensor in spec["sensors"] for feature in sensor["features"]]
    low = np.array([f["low"] for f in features], dtype=np.float32)
    high = np.array([f["high"] for f in features], dtype=np.float32)
    return spaces.Box(low, high, dtype=np.float32)


class MetalEnv(gym.Env[np.ndarray, np.integer]):
    """A built-in world whose observation is every sensor's reading.

    The reward is the motor reward; with `priced=True` the price of all sensors is subtracted from it at every step.
    `info` always says who was consulted, what that costs and what the motor action alone earned.
    """

    metadata = {"render_modes": []}

    def __init__(self, name: str, *, priced: bool = False, testing: bool = False, **settings: Any) -> None:
        self.task: Spec = BuiltIn(name, **settings)
        self._world = self.task.world(testing)
        self._priced = priced
        self._sensors = range(len(self.task.spec["sensors"]))
        self._cost = float(self.task.prices.sum())
        self.observation_space = observation_space(self.task.spec)
        self.action_space = spaces.Discrete(len(self.task.spec["actions"]))

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Begins an episode."""
        super().reset(seed=seed)
        self._world.reset(int(self.np_random.integers(2**SEED_BITS)))
        return self._observe(), self._info(0.0)

    def step(self, action: np.integer) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        """Carries out a motor action."""
        motor, end = self._world.step(int(action))
        reward = motor - self._cost if self._priced else motor
        return self._observe(), reward, end == 1, end == 2, self._info(motor)

    def _observe(self) -> np.ndarray:
        readings = np.concatenate([self._world.sense(i) for i in self._sensors])
        return readings.astype(np.float32)

    def _info(self, motor: float) -> dict[str, Any]:
        names = self.task.sensor_names
        return {"consulted": names, "sensor_cost": self._cost, "motor_reward": motor}


class MetalVectorEnv(VectorEnv):
    """Many worlds of one kind, stepped on threads in Rust; a finished one begins anew at its next step."""

    metadata = {"render_modes": [], "autoreset_mode": AutoresetMode.NEXT_STEP}

    def __init__(
        self, name: str, num_envs: int = 1, *, priced: bool = False, testing: bool = False, **settings: Any
    ) -> None:
        self.task: Spec = BuiltIn(name, **settings)
        self.num_envs = num_envs
        self._vector = _core.Vector(self.task.core, testing, num_envs)
        self._cost = float(self.task.prices.sum())
        self._priced = priced
        self._fresh = np.zeros(num_envs, dtype=bool)
        self.single_observation_space = observation_space(self.task.spec)
        self.single_action_space = spaces.Discrete(len(self.task.spec["actions"]))
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)

    def reset(
        self, *, seed: int | list[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Begins an episode everywhere; one seed is counted up from world to world."""
        if seed is None or isinstance(seed, int):
            seeds = [None if seed is None else seed + i for i in range(self.num_envs)]
        else:
            seeds = list(seed)
        self._fresh[:] = False
        return self._vector.reset(seeds), self._info(np.zeros(self.num_envs))

    def step(
        self, actions: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """One step everywhere; where an episode ended before, it begins the next one and earns nothing."""
        observations, motor, ends = self._vector.step([int(a) for a in actions])
        paid = np.where(self._fresh, 0.0, self._cost)
        self._fresh = ends != 0
        rewards = motor - paid if self._priced else motor
        return observations, rewards, ends == 1, ends == 2, self._info(motor)

    def _info(self, motor: np.ndarray) -> dict[str, Any]:
        return {"sensor_cost": np.full(self.num_envs, self._cost), "motor_reward": motor}
