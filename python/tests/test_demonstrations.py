"""Recordings of experts."""

from types import SimpleNamespace

import gymnasium as gym
import numpy as np
import pytest

import metal_rl
from conftest import Signpost
from metal_rl import PricedSensors, Sensor
from metal_rl.demonstrations import Recording, record

SENSORS = [Sensor("light", 0, 0.1), Sensor("clock", 1, 0.1)]


def tape(right, reward=0.0):
    return SimpleNamespace(
        observations=np.array([[right, 0.3], [right, 0.3]], dtype=np.float32),
        actions=np.array([right]),
        rewards=np.array([reward]),
        terminations=np.array([True]),
        truncations=np.array([False]),
    )


def test_a_recording_happens_whatever_is_done():
    env = Recording([tape(1, reward=-0.5)], Signpost.observation_space, Signpost.action_space)
    observation, _ = env.reset(seed=0)
    assert observation.tolist() == pytest.approx([1.0, 0.3]) and env.action == 1
    assert env.step(0)[1:4] == (-0.5, True, False)


def test_recordings_are_watched_first():
    class Counting(Signpost):
        steps = 0

        def step(self, action):
            Counting.steps += 1
            return super().step(action)

    task = PricedSensors(Counting(), SENSORS, demonstrations=[tape(0), tape(1)])
    before = Counting.steps
    metal_rl.learn(task, phases={"demonstration": 50, "fusion": 20, "attention": 30})
    assert Counting.steps - before == 50, "the demonstration came from the tape, the rest from the world"


def test_empty_and_foreign_recordings_are_refused():
    for episodes, match in [([], "no episode"), ([tape(7)], "not in")]:
        with pytest.raises(metal_rl.MetalError, match=match):
            PricedSensors(Signpost(), SENSORS, demonstrations=episodes)


def test_there_and_back_through_minari(tmp_path, monkeypatch):
    minari = pytest.importorskip("minari")
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path))
    # Minari writes down which environment made a dataset, so it must have a name.
    if "Signpost-v0" not in gym.registry:
        gym.register("Signpost-v0", entry_point="conftest:Signpost")
    env = gym.make("Signpost-v0")
    task = PricedSensors(env, SENSORS, expert=lambda env: env.unwrapped.right)
    record(task, "signpost/expert-v0", episodes=30)
    dataset = minari.load_dataset("signpost/expert-v0")
    assert dataset.total_episodes == 30
    assert all(episode.rewards.sum() == 0 for episode in dataset.iterate_episodes())
    watching = PricedSensors(gym.make("Signpost-v0"), SENSORS, demonstrations=dataset)
    mind = metal_rl.learn(watching, phases={"demonstration": 100, "fusion": 300, "attention": 2000})
    assert mind.evaluate(watching, episodes=50).total > -0.25
