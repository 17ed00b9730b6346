"""Other people's ways to act with priced sensors, on the very tasks METAL learns: `python -m metal_rl.peers --help`.

* Stable-Baselines3's PPO and DQN and sb3-contrib's MaskablePPO on `SensorCostEnv` (needs torch);
* a compact cost-sensitive DQN, after classification with costly features (numpy alone);
* for tasks of one step with an advisor, that is tables: CART, which buys what its path asks for, and a forest that
  always buys the k best groups (needs scikit-learn).
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from metal_rl.cost_dqn import CostDqn
from metal_rl.errors import refuse
from metal_rl.sensor_cost import SensorCostEnv
from metal_rl.tasks import Task

#: Sizes of CART and of the forest's subset that are compared.
LEAVES = (2, 3, 4, 6, 8, 12, 16, 32, 64)
MOST_GROUPS = 8
TREES = 200


@dataclass(frozen=True)
class Result:
    """One training of one peer, tested: means per episode."""

    #: Who.
    name: str
    #: Motor reward.
    motor: float
    #: Prices paid (≥ 0).
    cost: float
    #: Sensors read per motor step.
    looks: float
    #: Seconds of processor time.
    cpu_secs: float

    @property
    def total(self) -> float:
        """Reward minus prices."""
        return self.motor - self.cost


class MotorBudget(SensorCostEnv):
    """`SensorCostEnv` that counts motor steps, so that everybody may learn from as many."""

    motor_steps = 0

    def step(self, action: Any) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        """A look, or a motor action, which is counted."""
        after = super().step(action)
        self.motor_steps += int(after[-1]["moved"])
        return after


def drive(env: SensorCostEnv, choose: Callable[[np.ndarray, np.ndarray], int], episodes: int) -> tuple[float, ...]:
    """Motor reward and price per episode, and looks per motor step, of `choose(observation, mask)`."""
    motor = cost = 0.0
    looks = moves = 0
    for episode in range(episodes):
        observation, _ = env.reset(seed=1_000_003 + episode)
        over = False
        while not over:
            observation, _, ended, cut, info = env.step(choose(observation, env.action_masks()))
            if info["moved"]:
                motor, cost = motor + info["motor_reward"], cost + info["sensor_cost"]
                looks, moves = looks + len(info["consulted"]), moves + 1
            over = ended or cut
    return motor / episodes, cost / episodes, looks / max(1, moves)


def reinforcement(name: str, task: Task, steps: int, seed: int, episodes: int) -> Result:
    """`name` (PPO, DQN, MaskablePPO or cost DQN) after `steps` motor steps."""
    started = time.process_time()
    env = MotorBudget(task)
    env.reset(seed=seed)
    choose = _cost_dqn(env, steps, seed) if name == "cost DQN" else _sb3(name, env, steps, seed)
    motor, cost, looks = drive(SensorCostEnv(task, testing=True), choose, episodes)
    return Result(name, motor, cost, looks, time.process_time() - started)


def _cost_dqn(env: MotorBudget, steps: int, seed: int) -> Callable[[np.ndarray, np.ndarray], int]:
    student = CostDqn(env.observation_space.shape[0], int(env.action_space.n), seed=seed)
    student.learn(env, steps)
    return student.choose


def _sb3(name: str, env: MotorBudget, steps: int, seed: int) -> Callable[[np.ndarray, np.ndarray], int]:
    """Library defaults; stops when the motor steps are used up."""
    from stable_baselines3 import DQN, PPO

    if name == "MaskablePPO":
        from sb3_contrib import MaskablePPO

        model = MaskablePPO("MlpPolicy", env, seed=seed, device="cpu")
    else:
        model = {"PPO": PPO, "DQN": DQN}[name]("MlpPolicy", env, seed=seed, device="cpu")
    looks = len(env.task.spec["sensors"])
    model.learn(steps * (1 + looks), callback=lambda *_: env.motor_steps < steps)
    if name == "MaskablePPO":
        return lambda seen, mask: int(model.predict(seen, action_masks=mask, deterministic=True)[0])
    return lambda seen, mask: int(model.predict(seen, deterministic=True)[0])


def examples(task: Task, testing: bool = False) -> tuple[np.ndarray, np.ndarray]:
    """All rows of a task of one step, with the advisor's classes: drawn until nothing new comes."""
    world, sensors = task.world(testing), len(task.spec["sensors"])
    if task.spec["horizon"] != 1 or world.advise() is None:
        raise refuse("task", "classifiers need a task of one step with an advisor, such as a table")
    rows: dict[bytes, tuple[np.ndarray, int]] = {}
    seed = stale = 0
    while stale < 500 + 2 * len(rows):
        world.reset(seed)
        row = np.concatenate([world.sense(i) for i in range(sensors)])
        known = len(rows)
        rows.setdefault(row.tobytes(), (row, int(world.advise())))
        seed, stale = seed + 1, stale + 1 if len(rows) == known else 0
    x, y = zip(*rows.values())
    return np.array(x), np.array(y)


def _groups(task: Task) -> tuple[np.ndarray, np.ndarray]:
    """The group that each column belongs to, and the price of each group."""
    sensors = task.spec["sensors"]
    owner = np.repeat(np.arange(len(sensors)), [len(sensor["features"]) for sensor in sensors])
    return owner, np.array([float(sensor["price"]) for sensor in sensors])


def _verdict(task: Task) -> tuple[float, float]:
    """What right and wrong earn."""
    world = task.world()
    world.reset(0)
    label = int(world.advise())
    right, _ = world.step(label)
    world.reset(0)
    wrong, _ = world.step((label + 1) % len(task.spec["actions"]))
    return right, wrong


def trees(task: Task, seed: int) -> Iterator[Result]:
    """CART at every size; a row pays each group on its path once."""
    from sklearn.tree import DecisionTreeClassifier

    (x, y), (test_x, test_y) = examples(task), examples(task, testing=True)
    owner, prices = _groups(task)
    for leaves in LEAVES:
        started = time.process_time()
        tree = DecisionTreeClassifier(max_leaf_nodes=leaves, random_state=seed).fit(x, y)
        paths, bought = tree.decision_path(test_x), np.zeros((len(test_x), len(prices)))
        for row in range(len(test_x)):
            nodes = paths.indices[paths.indptr[row] : paths.indptr[row + 1]]
            columns = tree.tree_.feature[nodes]
            bought[row, owner[columns[columns >= 0]]] = 1.0
        secs = time.process_time() - started
        yield _classified(task, f"CART, {leaves} leaves", tree.predict(test_x) == test_y, bought, secs)


def forests(task: Task, seed: int) -> Iterator[Result]:
    """A forest on the k groups that a forest on all of them finds most important."""
    from sklearn.ensemble import RandomForestClassifier

    (x, y), (test_x, test_y) = examples(task), examples(task, testing=True)
    owner, prices = _groups(task)
    forest = RandomForestClassifier(TREES, random_state=seed).fit(x, y)
    order = np.argsort(-np.bincount(owner, weights=forest.feature_importances_))
    for k in [*range(1, min(MOST_GROUPS, len(prices)) + 1), len(prices)]:
        started = time.process_time()
        columns = np.isin(owner, order[:k])
        forest = RandomForestClassifier(TREES, random_state=seed).fit(x[:, columns], y)
        bought = np.zeros((len(test_x), len(prices)))
        bought[:, order[:k]] = 1.0
        right = forest.predict(test_x[:, columns]) == test_y
        yield _classified(task, f"forest, top {k}", right, bought, time.process_time() - started)


def _classified(task: Task, name: str, right: np.ndarray, bought: np.ndarray, secs: float) -> Result:
    """Accuracy and bills as a result."""
    gain, loss = _verdict(task)
    motor = float(np.where(right, gain, loss).mean())
    cost = float((bought @ _groups(task)[1]).mean())
    return Result(name, motor, cost, float(bought.sum(axis=1).mean()), secs)
