"""Many trainings: plans × seeds, on threads of this machine or on a Ray cluster, with the same results."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import metal_rl.minds as minds
from metal_rl.errors import refuse
from metal_rl.tasks import Task

#: How often a run that failed is tried again.
RETRIES = 2


@dataclass(frozen=True)
class Plan:
    """What is trained: a function that makes the task (each run makes its own), and arguments of `learn`."""

    task: Callable[[], Task]
    learn: Mapping[str, Any]
    episodes: int = 100
    name: str = "plan"


@dataclass(frozen=True)
class Run:
    """One training of one plan, tested."""

    plan: str
    seed: int
    #: The tested mind: motor reward, prices, looks per episode.
    score: minds.Score

    @property
    def total(self) -> float:
        """Mean over test episodes of motor reward minus price."""
        return self.score.total


def sweep(
    plans: Plan | Sequence[Plan], seeds: Sequence[int], on: str = "threads", workers: int | None = None
) -> Iterator[Run]:
    """Trains every plan on every seed and yields each run when it is done, in no certain order.

    `on="threads"` uses this machine; `on="ray"` one Ray task per run (connect with `ray.init` before, or it starts
    one here). A run that fails is tried again, on another machine if its own is gone. Results depend on plan and
    seed only: they are the same bits everywhere.
    """
    plans = [plans] if isinstance(plans, Plan) else list(plans)
    jobs = [(plan, int(seed)) for plan in plans for seed in seeds]
    if on == "threads":
        return _on_threads(jobs, workers)
    if on == "ray":
        return _on_ray(jobs)
    raise refuse("on", f"{on!r}: threads or ray")


def train(plan: Plan, seed: int) -> Run:
    """One run, here and now."""
    task = plan.task()
    mind = minds.learn(task, seed=seed, **plan.learn)
    return Run(plan.name, seed, mind.evaluate(task, episodes=plan.episodes, seed=seed))


def _stubborn(plan: Plan, seed: int) -> Run:
    for _ in range(RETRIES):
        try:
            return train(plan, seed)
        except OSError:
            # A file or a link that failed once may work; a wrong plan is wrong for ever and is not tried again.
            continue
    return train(plan, seed)


def _on_threads(jobs: list[tuple[Plan, int]], workers: int | None) -> Iterator[Run]:
    with ThreadPoolExecutor(workers) as pool:
        running = [pool.submit(_stubborn, plan, seed) for plan, seed in jobs]
        for done in as_completed(running):
            yield done.result()


def _on_ray(jobs: list[tuple[Plan, int]]) -> Iterator[Run]:
    import ray

    if not ray.is_initialized():
        ray.init()
    remote = ray.remote(train).options(num_cpus=1, max_retries=RETRIES, retry_exceptions=[OSError])
    with _sent_by_value({getattr(plan.task, "__module__", None) for plan, _ in jobs}):
        running = [remote.remote(plan, seed) for plan, seed in jobs]
    while running:
        done, running = ray.wait(running)
        yield from ray.get(done)


@contextmanager
def _sent_by_value(names: set[str | None]) -> Iterator[None]:
    """The script that says how tasks are made need not lie on every machine."""
    from ray import cloudpickle

    scripts = [sys.modules[name] for name in names if name in sys.modules and name != "__main__"]
    for script in scripts:
        cloudpickle.register_pickle_by_value(script)
    try:
        yield
    finally:
        for script in scripts:
            cloudpickle.unregister_pickle_by_value(script)
