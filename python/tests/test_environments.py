"""Our worlds as Gymnasium environments."""

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import metal_rl
from metal_rl import MetalVectorEnv, SensorCostEnv
from metal_rl.registration import WORLDS


@pytest.mark.parametrize("name", WORLDS)
def test_gymnasiums_checker_is_content(name):
    check_env(gym.make(name).unwrapped, skip_render_check=True)


@pytest.mark.parametrize("name", WORLDS)
def test_an_observation_is_every_sensor_and_info_says_what_it_costs(name):
    env = gym.make(name)
    observation, info = env.reset(seed=3)
    assert env.observation_space.contains(observation)
    task = env.unwrapped.task
    assert info["consulted"] == task.sensor_names
    assert info["sensor_cost"] == pytest.approx(task.prices.sum())
    assert info["motor_reward"] == 0.0


def test_priced_rewards_are_motor_rewards_minus_the_price():
    plain, priced = gym.make("metal_rl/Maze-v0"), gym.make("metal_rl/Maze-v0", priced=True)
    plain.reset(seed=1), priced.reset(seed=1)
    _, reward, *_, info = plain.step(0)
    assert reward == info["motor_reward"]
    assert priced.step(0)[1] == pytest.approx(reward - info["sensor_cost"])


def test_the_aliasing_of_the_maze_can_be_seen_by_hand():
    """Eq. (14): X merges the cells of a column, so 9 cells have 3 readings of X and 3 of Y."""
    env = gym.make("metal_rl/Maze-v0", side=3, goal={"x": 2, "y": 2})
    cells = {tuple(env.reset(seed=s)[0].tolist()) for s in range(200)}
    assert len(cells) == 8, "all but the goal"
    assert len({x for x, _ in cells}) == 3 and len({y for _, y in cells}) == 3


def test_vector_worlds_equal_single_lanes_and_begin_anew():
    lanes = MetalVectorEnv("maze", num_envs=4, side=3, goal={"x": 2, "y": 2})
    first, _ = lanes.reset(seed=5)
    again, _ = lanes.reset(seed=5)
    assert np.array_equal(first, again) and first.shape == (4, 2)
    over = np.zeros(4, dtype=bool)
    seen = 0
    for step in range(60):
        was_over = over
        observations, rewards, terminated, truncated, info = lanes.step(np.full(4, step % 4))
        over = terminated | truncated
        assert not (over & was_over).any(), "the step after an end begins an episode"
        assert (rewards[was_over] == 0).all()
        assert np.array_equal(info["motor_reward"], rewards)
        seen += int(over.sum())
    assert seen > 0


def test_make_vec_finds_the_rust_threads():
    lanes = gym.make_vec("metal_rl/Toy-v0", num_envs=3)
    assert isinstance(lanes.unwrapped, MetalVectorEnv)
    observations, _ = lanes.reset(seed=0)
    assert lanes.observation_space.contains(observations)


def test_vector_refuses_wrong_actions_by_value():
    lanes = MetalVectorEnv("maze", num_envs=2)
    lanes.reset(seed=0)
    with pytest.raises(metal_rl.MetalError, match="9") as refused:
        lanes.step(np.array([0, 9]))
    assert refused.value.field == "action"


def test_consult_then_act(maze):
    env = SensorCostEnv(maze)
    check_env(env, skip_render_check=True)
    observation, _ = env.reset(seed=2)
    assert (observation == 0).all()
    assert env.action_masks().tolist() == [True] * 6
    observation, reward, *_, info = env.step(4)
    assert reward == pytest.approx(-0.1) and info["consulted"] == ("X",) and observation[2:].tolist() == [1, 0]
    assert env.action_masks().tolist() == [True] * 4 + [False, True]
    observation, reward, *_, info = env.step(0)
    assert info["moved"] and info["sensor_cost"] == pytest.approx(0.1) and reward == info["motor_reward"]
    assert (observation == 0).all(), "readings do not outlive the motor step"


def test_looking_for_ever_takes_time(maze):
    """Whoever only looks pays for every look and for every motor step, and the episode goes on."""
    looking, moving = SensorCostEnv(maze), SensorCostEnv(maze)
    looking.reset(seed=0), moving.reset(seed=0)
    for _ in range(3):
        after = [looking.step(4) for _ in range(5)]
        assert [info["moved"] for *_, info in after] == [False] * 4 + [True]
        observation, reward, ended, cut, info = after[-1]
        _, motor, would_end, would_cut, _ = moving.step(0)
        assert reward == pytest.approx(motor - 0.1) and info["motor_reward"] == motor
        assert info["consulted"] == ("X",) * 5 and info["sensor_cost"] == pytest.approx(0.5)
        assert (observation == 0).all() and (ended, cut) == (would_end, would_cut)


@pytest.mark.peers
def test_stable_baselines_checker_is_content(maze):
    checker = pytest.importorskip("stable_baselines3.common.env_checker")
    for name in WORLDS:
        checker.check_env(gym.make(name).unwrapped)
    checker.check_env(SensorCostEnv(maze))
