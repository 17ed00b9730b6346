"""A compact cost-sensitive deep Q-network in numpy: looks and moves are actions of one network, closed ones are masked.

After classification with costly features (CwCF): double Q-learning with replay and a slowly following target network on
`SensorCostEnv`, for any horizon. A peer to compare with, not part of METAL.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np


@dataclass
class Network:
    """Two hidden layers of rectified units, trained by Adam on single outputs."""

    inputs: int
    outputs: int
    hidden: int
    rng: np.random.Generator
    rate: float = 1e-3
    weights: list[np.ndarray] = field(default_factory=list)

    def __post_init__(self) -> None:
        widths = [self.inputs, self.hidden, self.hidden, self.outputs]
        for a, b in zip(widths, widths[1:]):
            spread = np.sqrt(2 / a)
            self.weights += [self.rng.normal(0, spread, (a, b)).astype(np.float32), np.zeros(b, np.float32)]
        self._m = [np.zeros_like(w) for w in self.weights]
        self._v = [np.zeros_like(w) for w in self.weights]
        self._steps = 0

    def layers(self, x: np.ndarray) -> list[np.ndarray]:
        """What every layer says, the outputs last."""
        said = [x]
        for i in range(0, 6, 2):
            x = x @ self.weights[i] + self.weights[i + 1]
            said.append(np.maximum(x, 0) if i < 4 else x)
            x = said[-1]
        return said

    def train(self, x: np.ndarray, chosen: np.ndarray, targets: np.ndarray) -> None:
        """One step towards `targets` at the outputs `chosen`; errors beyond 1 count as 1 (Huber)."""
        said, rows = self.layers(x), np.arange(len(x))
        error = np.zeros_like(said[-1])
        error[rows, chosen] = np.clip(said[-1][rows, chosen] - targets, -1, 1) / len(x)
        gradients: list[np.ndarray] = []
        for i in (4, 2, 0):
            layer = said[i // 2]
            gradients = [layer.T @ error, error.sum(axis=0), *gradients]
            error = (error @ self.weights[i].T) * (layer > 0)
        self._adam(gradients)

    def _adam(self, gradients: list[np.ndarray]) -> None:
        self._steps += 1
        for w, g, m, v in zip(self.weights, gradients, self._m, self._v):
            m += 0.1 * (g - m)
            v += 0.001 * (g * g - v)
            unbiased = m / (1 - 0.9**self._steps), v / (1 - 0.999**self._steps)
            w -= self.rate * unbiased[0] / (np.sqrt(unbiased[1]) + 1e-8)

    def follow(self, other: Network, share: float) -> None:
        """Weights move towards those of `other`."""
        for mine, theirs in zip(self.weights, other.weights):
            mine += share * (theirs - mine)


class CostDqn:
    """The student: `learn(env, steps)`, then `choose(observation, mask)`."""

    def __init__(
        self, inputs: int, choices: int, *, seed: int = 0, hidden: int = 128, gamma: float = 0.99, capacity: int = 50_000
    ) -> None:
        self.rng = np.random.default_rng(seed)
        self.network = Network(inputs, choices, hidden, self.rng)
        self.target = Network(inputs, choices, hidden, np.random.default_rng(seed))
        self.target.follow(self.network, 1.0)
        self.gamma, self.capacity, self.size = gamma, capacity, 0
        self._seen = np.zeros((capacity, inputs), np.float32)
        self._next = np.zeros((capacity, inputs), np.float32)
        self._open = np.zeros((capacity, choices), bool)
        self._chosen = np.zeros(capacity, np.int64)
        self._facts = np.zeros((capacity, 2), np.float32)

    def choose(self, observation: np.ndarray, mask: np.ndarray) -> int:
        """The best open choice."""
        values = self.network.layers(observation[None].astype(np.float32))[-1][0]
        return int(np.argmax(np.where(mask, values, -np.inf)))

    def learn(self, env: Any, steps: int, batch: int = 64, every: int = 4) -> None:
        """Learns from `steps` motor steps; random choices fall from all to one in twenty over half of them."""
        observation, _ = env.reset()
        moves, choices = 0, 0
        while moves < steps:
            mask = env.action_masks()
            explore = max(0.05, 1 - 1.9 * moves / steps)
            wild = self.rng.random() < explore
            choice = self._wild(mask, env.motor_actions) if wild else self.choose(observation, mask)
            after, reward, ended, cut, info = env.step(choice)
            self._keep((observation, choice, after), (reward, not ended, info["moved"]), env.action_masks())
            observation = env.reset()[0] if ended or cut else after
            moves, choices = moves + int(info["moved"]), choices + 1
            if choices % every == 0 and self.size > 500:
                self._replay(batch)

    def _wild(self, mask: np.ndarray, moves: int) -> int:
        """A random choice: moves and looks in equal shares, however many there are of each."""
        looks = np.flatnonzero(mask[moves:])
        if len(looks) and self.rng.random() < 0.5:
            return int(moves + self.rng.choice(looks))
        return int(self.rng.integers(moves))

    def _keep(self, passage: tuple[Any, int, Any], facts: tuple[float, bool, bool], mask: np.ndarray) -> None:
        (reward, goes_on, moved), place = facts, self.size % self.capacity
        self._seen[place], self._chosen[place], self._next[place] = passage
        # Time passes with moves, not with looks.
        discount = float(goes_on) * (self.gamma if moved else 1.0)
        self._facts[place], self._open[place] = (reward, discount), mask
        self.size += 1

    def _replay(self, batch: int) -> None:
        places = self.rng.integers(min(self.size, self.capacity), size=batch)
        future = np.where(self._open[places], self.network.layers(self._next[places])[-1], -np.inf).argmax(axis=1)
        worth = self.target.layers(self._next[places])[-1][np.arange(batch), future]
        rewards, discounts = self._facts[places].T
        self.network.train(self._seen[places], self._chosen[places], rewards + discounts * worth)
        self.target.follow(self.network, 0.01)
