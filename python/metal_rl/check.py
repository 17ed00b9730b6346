"""Is a task well posed? What it costs to be blind, what each sensor tells, how prices and rewards compare."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field

import numpy as np

from metal_rl.tasks import Task


@dataclass(frozen=True)
class Check:
    """The findings; `print(check)` shows them."""

    #: Mean motor reward per episode of every constant action.
    blind: dict[str, float]
    #: Mean motor reward per episode of random actions.
    random: float
    #: Smallest and largest motor reward of a step.
    rewards: tuple[float, float]
    #: Share of a sensor's features that ever change.
    alive: dict[str, float]
    #: Bits that a sensor tells about which episode of the drive one is in and how far (at most log2 of the samples).
    bits: dict[str, float]
    #: What is badly posed.
    problems: list[str] = field(default_factory=list)

    def __str__(self) -> str:
        best = max(self.blind, key=lambda name: self.blind[name])
        lines = [
            f"blind: always {best} earns {self.blind[best]:.3f} per episode; at random {self.random:.3f}",
            f"motor reward of a step: {self.rewards[0]:.3f} … {self.rewards[1]:.3f}",
            *(f"sensor {name}: {self.bits[name]:.2f} bits" for name in self.bits),
            *(f"problem: {problem}" for problem in self.problems),
        ]
        return "\n".join(lines)


def check(task: Task, episodes: int = 20, seed: int = 0) -> Check:
    """Drives `task` blindly and at random, and says what is badly posed. Every sensor is read, nobody pays."""
    rng = np.random.default_rng(seed)
    actions, world = len(task.spec["actions"]), task.world()
    blind = {
        name: float(np.mean([_episode(task, world, s, lambda a=a: a)[0] for s in range(episodes)]))
        for a, name in enumerate(task.spec["actions"])
    }
    drives = [
        _episode(task, world, seed + s, lambda: int(rng.integers(actions)), read=True) for s in range(episodes)
    ]
    rewards = np.concatenate([steps for _, steps, _ in drives])
    readings = {
        sensor["name"]: np.array([r[i] for _, _, log in drives for r in log])
        for i, sensor in enumerate(task.spec["sensors"])
    }
    alive = {name: float((np.ptp(values, axis=0) > 0).mean()) for name, values in readings.items()}
    bits = {name: _entropy_bits(values) for name, values in readings.items()}
    found = Check(
        blind,
        float(np.mean([total for total, _, _ in drives])),
        (float(rewards.min()), float(rewards.max())),
        alive,
        bits,
    )
    found.problems.extend(_problems(task, found))
    return found


def _episode(task, world, seed, choose, read=False):  # noqa: ANN001, ANN202
    world.reset(seed)
    steps, log = [], []
    for _ in range(task.spec["horizon"]):
        if read:
            log.append([np.array(world.sense(i)) for i in range(len(task.spec["sensors"]))])
        reward, end = world.step(choose())
        steps.append(reward)
        if end:
            break
    return float(np.sum(steps)), np.array(steps), log


def _entropy_bits(values: np.ndarray) -> float:
    """Entropy of the readings, each feature cut into 8 parts."""
    low, span = values.min(axis=0), np.ptp(values, axis=0)
    cells = np.floor(7.999 * (values - low) / np.where(span > 0, span, 1.0)).astype(int)
    counts = np.array(list(Counter(map(tuple, cells)).values()), dtype=float)
    shares = counts / counts.sum()
    return float(-(shares * np.log2(shares)).sum())


def _problems(task: Task, found: Check) -> list[str]:
    problems = []
    low, high = found.rewards
    if low == high and len(set(found.blind.values())) == 1:
        problems.append("every motor action earns the same: there is nothing to learn")
    prices = [sensor["price"] for sensor in task.spec["sensors"]]
    if max(prices) == 0:
        problems.append("every look is free: attention has nothing to save")
    width = max(high - low, max(found.blind.values()) - min(found.blind.values()))
    for sensor in task.spec["sensors"]:
        name, price = sensor["name"], sensor["price"]
        if width > 0 and price > width:
            problems.append(f"sensor {name} costs {price:g}, more than any motor action can win or lose ({width:g})")
        if found.alive[name] == 0:
            problems.append(f"sensor {name} never changes")
    return problems
