"""What many tests need: a small environment with something worth looking at."""

from __future__ import annotations

import gymnasium as gym
import numpy as np
import pytest
from gymnasium import spaces

import metal_rl
from metal_rl import PricedSensors, Sensor


class Signpost(gym.Env):
    """One step: a light says which of two doors is right, a clock says nothing."""

    observation_space = spaces.Box(0.0, 1.0, (2,), dtype=np.float32)
    action_space = spaces.Discrete(2)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.right = int(self.np_random.integers(2))
        self.clock = self.np_random.random()
        return self._see(), {}

    def step(self, action):
        reward = 0.0 if action == self.right else -1.0
        return self._see(), reward, True, False, {}

    def _see(self):
        return np.array([self.right, self.clock], dtype=np.float32)


@pytest.fixture
def signpost() -> PricedSensors:
    env = gym.wrappers.TimeLimit(Signpost(), 1)
    sensors = [Sensor("light", 0, cost=0.1), Sensor("clock", 1, cost=0.1)]
    return PricedSensors(env, sensors, actions={"left": 0, "right": 1}, name="Signpost-v0")


@pytest.fixture
def quick() -> dict[str, int]:
    """Budgets that only show that everything works."""
    return {"demonstration": 0, "fusion": 300, "attention": 1500}


@pytest.fixture
def maze() -> metal_rl.BuiltIn:
    return metal_rl.BuiltIn("maze", side=3, goal={"x": 2, "y": 2})
