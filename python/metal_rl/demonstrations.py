"""Recordings of an expert, in Minari's layout: watched in Phase I, or made from whoever drives a task."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import gymnasium as gym
import numpy as np
from gymnasium import spaces

from metal_rl.errors import refuse

if TYPE_CHECKING:
    from metal_rl.minds import Mind
    from metal_rl.priced import PricedSensors


class Recording(gym.Env):
    """Recorded episodes as an environment: whatever is done in it, what was recorded happens.

    `episodes` is a Minari dataset, or any sequence of objects with `observations`, `actions`, `rewards`,
    `terminations` and `truncations`. `action` is what the recorded expert does next.
    """

    def __init__(self, episodes: Any, observation_space: spaces.Space, action_space: spaces.Space) -> None:
        recorded = episodes.iterate_episodes() if hasattr(episodes, "iterate_episodes") else episodes
        self._episodes = [episode for episode in recorded if len(episode.rewards)]
        if not self._episodes:
            raise refuse("demonstrations", "no episode with a step in it")
        self.observation_space = observation_space
        self.action_space = action_space
        self._episode, self._at = self._episodes[0], 0
        if not observation_space.contains(self._see()):
            raise refuse("demonstrations", f"observations are not in {observation_space}")

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Begins one of the recorded episodes."""
        super().reset(seed=seed)
        self._episode = self._episodes[int(self.np_random.integers(len(self._episodes)))]
        self._at = 0
        return self._see(), {}

    @property
    def action(self) -> Any:
        """What the expert did here; after the last step, what it did then."""
        return self._episode.actions[min(self._at, len(self._episode.rewards) - 1)]

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """The next recorded step."""
        at = self._at
        self._at += 1
        terminated = bool(self._episode.terminations[at])
        # A recording that stops without an end was cut: that is a time limit.
        cut = bool(self._episode.truncations[at]) or self._at == len(self._episode.rewards)
        return self._see(), float(self._episode.rewards[at]), terminated, cut and not terminated, {}

    def _see(self) -> Any:
        return _at(self._episode.observations, self._at)


def _at(observations: Any, index: int) -> Any:
    if isinstance(observations, dict):
        return {key: _at(value, index) for key, value in observations.items()}
    return np.asarray(observations[index])


def record(
    task: PricedSensors, dataset_id: str, episodes: int, driver: Mind | None = None, seed: int = 0
) -> Any:
    """Drives `task` and keeps what happened as the Minari dataset `dataset_id` (needs `pip install metal-rl[minari]`).

    `driver`: a mind; nobody: the task's expert. What is recorded are the environment's own observations and actions.
    """
    import minari
    from minari.data_collector import EpisodeBuffer

    tape = _Tape(task.env)
    stage = task._elsewhere(tape)
    buffers = []
    for episode in range(episodes):
        stage._reset(seed + episode)
        end = 0
        while not end:
            _, end = stage._step(_choice(stage, driver))
        whole = {key: _stacked(value) for key, value in tape.log.items()}
        buffers.append(EpisodeBuffer(id=episode, seed=seed + episode, **whole))
    return minari.create_dataset_from_buffers(
        dataset_id,
        buffers,
        env=task.env.spec,
        observation_space=task.env.observation_space,
        action_space=task.env.action_space,
        algorithm_name="metal_rl",
    )


class _Tape(gym.Wrapper):
    """Writes down one episode."""

    log: dict[str, list[Any]]

    def reset(self, **arguments: Any) -> tuple[Any, dict[str, Any]]:
        observation, info = self.env.reset(**arguments)
        keys = ("actions", "rewards", "terminations", "truncations")
        self.log = {"observations": [observation], **{key: [] for key in keys}}
        return observation, info

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        observation, reward, terminated, truncated, info = self.env.step(action)
        row = (observation, action, float(reward), terminated, truncated)
        for entries, entry in zip(self.log.values(), row):
            entries.append(entry)
        return observation, reward, terminated, truncated, info


def _stacked(entries: list[Any]) -> Any:
    if isinstance(entries[0], dict):
        return {key: _stacked([entry[key] for entry in entries]) for key in entries[0]}
    return np.stack([np.asarray(entry) for entry in entries])


def _choice(stage: PricedSensors, driver: Mind | None) -> int:
    if driver is not None:
        names = stage.sensor_names
        return driver.act(lambda name: stage._sense(names.index(name))).action
    advice = stage._advise()
    if advice is None:
        raise refuse("driver", "nobody: give a mind, or a task with an expert")
    return advice
