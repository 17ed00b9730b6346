"""`python -m metal_rl.compare TASK`: METAL and its peers on one task, each trained on several seeds.

Every seed of a table has a split of its rows, or a generated table, of its own, the same for everybody: intervals say
what other rows would bring.

Tasks: every built-in one, `wine` and `breast_cancer` of scikit-learn, and `cartpole` with four readings at 0.05 each.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable, Sequence

import gymnasium as gym
import numpy as np

from metal_rl import peers
from metal_rl.errors import refuse
from metal_rl.minds import learn
from metal_rl.peers import Result
from metal_rl.priced import PricedSensors
from metal_rl.sensors import Sensor
from metal_rl.tabular import from_arrays
from metal_rl.tasks import BuiltIn, Task

#: Everybody who can be compared, in the order of the table.
EVERYBODY = ("METAL", "cost DQN", "PPO", "DQN", "MaskablePPO", "CART", "forest")
RESAMPLES = 2000


#: Tasks whose table is generated from a seed of its own.
GENERATED = ("cube", "cube_nm")
#: Tables of scikit-learn.
CLASSICS = ("wine", "breast_cancer")


def named(name: str, draw: int = 1, price: float | None = None) -> Task:
    """The task called `name`; of a table, the split into training and test rows (or the table) of number `draw`.

    `price`: of a look at anything in a table.
    """
    if price is not None and name not in (*GENERATED, *CLASSICS):
        raise refuse("price", f"{name} is no table")
    if name == "cartpole":
        readings = ("position", "speed", "angle", "spin")
        sensors = [Sensor(reading, i, cost=0.05) for i, reading in enumerate(readings)]
        return PricedSensors(gym.make("CartPole-v1"), sensors, actions={"left": 0, "right": 1})
    if name in CLASSICS:
        from sklearn import datasets

        table = getattr(datasets, f"load_{name}")()
        classes = [str(table.target_names[label]) for label in table.target]
        options = {} if price is None else {"default_price": price}
        return from_arrays(table.data, classes, list(table.feature_names), name=name, split_seed=draw, **options)
    options = {} if price is None else {"look_price": price}
    return BuiltIn(name, seed=draw, **options) if name in GENERATED else BuiltIn(name)


def train(who: str, task: Task, wanted: argparse.Namespace, seed: int) -> list[Result]:
    """Results of one training of `who`; CART and the forest come in several sizes."""
    if who == "CART":
        return list(peers.trees(task, seed))
    if who == "forest":
        return list(peers.forests(task, seed))
    if who != "METAL":
        return [peers.reinforcement(who, task, wanted.steps, seed, wanted.episodes)]
    started = time.process_time()
    mind = learn(task, steps=wanted.steps, phases=wanted.phases, recipe=wanted.recipe, seed=seed)
    score = mind.evaluate(task, wanted.episodes)
    motor, cost = float(score.motor.mean()), float(score.price.mean())
    return [Result(who, motor, cost, score.looks_per_step, time.process_time() - started)]


def interquartile_mean(values: np.ndarray) -> np.ndarray:
    """Mean of the middle half along the last axis; values on its border count in part."""
    ordered, n = np.sort(values, axis=-1), values.shape[-1]
    places = np.arange(n)
    weights = np.clip(np.minimum(places + 1, 0.75 * n) - np.maximum(places, 0.25 * n), 0.0, 1.0)
    return (ordered * weights).sum(axis=-1) / weights.sum()


def estimate(values: Sequence[float]) -> tuple[float, float, float]:
    """Interquartile mean over trainings, with its 95 % bootstrap interval."""
    found = np.array(values, dtype=float)
    draws = np.random.default_rng(0).integers(len(found), size=(RESAMPLES, len(found)))
    low, high = np.quantile(interquartile_mean(found[draws]), [0.025, 0.975])
    return float(interquartile_mean(found)), float(low), float(high)


def line(name: str, results: Sequence[Result]) -> str:
    """A row of the table, in Markdown."""

    def cell(number: Callable[[Result], float], digits: int) -> str:
        middle, low, high = estimate([number(result) for result in results])
        if len(results) < 2:
            return f"{middle:.{digits}f}"
        return f"{middle:.{digits}f} [{low:.{digits}f}, {high:.{digits}f}]"

    total, motor, looks = cell(lambda r: r.total, 3), cell(lambda r: r.motor, 3), cell(lambda r: r.looks, 2)
    secs = np.mean([result.cpu_secs for result in results])
    return f"| {name} | {total} | {motor} | {looks} | {secs:.0f} | {len(results)} |"


def main(words: Sequence[str] | None = None) -> None:
    """The command."""
    parser = argparse.ArgumentParser(prog="python -m metal_rl.compare", description=__doc__)
    parser.add_argument("task")
    parser.add_argument("--steps", type=int, default=60_000, help="motor steps of learning")
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--episodes", type=int, default=1000, help="test episodes per training")
    parser.add_argument("--phases", type=json.loads, metavar="JSON", help="METAL's motor steps by phase")
    parser.add_argument("--recipe", type=json.loads, metavar="JSON", help="fields of METAL's recipe")
    parser.add_argument("--price", type=float, help="of every look, where the task is a table")
    parser.add_argument("--who", nargs="*", choices=EVERYBODY, default=list(EVERYBODY))
    wanted = parser.parse_args(words)
    print("| who | reward − cost | reward | looks per step | CPU s | trainings |\n|---|---|---|---|---|---|")
    for who in wanted.who:
        found: dict[str, list[Result]] = {}
        for seed in range(1, wanted.seeds + 1):
            for result in train(who, named(wanted.task, seed, wanted.price), wanted, seed):
                found.setdefault(result.name, []).append(result)
        for name, results in found.items():
            print(line(name, results), flush=True)


if __name__ == "__main__":
    main()
