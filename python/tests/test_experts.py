"""Experts of every kind, and the special cases of decision-level attention: one perfect expert among noise,
complementary local experts, a duplicated one, an adversarial one, and one that dies."""

import numpy as np
import pytest

import metal_rl
from conftest import Signpost
from metal_rl import Expert, PricedSensors

BUDGET = {"demonstration": 0, "fusion": 200, "attention": 3000}
TEST = 300


class Doors(Signpost):
    """Four doors; the room (0 or 1) and the door are what experts may know."""

    def reset(self, *, seed=None, options=None):
        super(Signpost, self).reset(seed=seed)
        self.room, self.right = int(self.np_random.integers(2)), int(self.np_random.integers(2))
        self.clock = self.np_random.random()
        return self._see(), {}


def facts(env):
    world = env.unwrapped
    return np.array([world.room, world.right, world.clock])


def task_of(*experts):
    return PricedSensors(Doors(), list(experts))


def learned(task, seed=1, attention=3000):
    mind = metal_rl.learn(task, phases={**BUDGET, "attention": attention}, seed=seed)
    return mind.evaluate(task, episodes=TEST)


def perfect(seen):
    return int(seen[1])


def noise(seen):
    return [0.5 + 0.4 * np.sin(1e6 * seen[2]), 0.5]


def adversary(seen):
    return 1 - int(seen[1])


def local(home):
    """Knows its own room; elsewhere it says that it does not know."""
    return lambda seen: perfect(seen) if int(seen[0]) == home else [0.5, 0.5]


def expert(name, mind, cost=0.1, **options):
    return Expert(name, mind, facts, actions=2, cost=cost, **options)


def test_one_perfect_expert_among_noise():
    experts = [expert(f"noise{i}", noise) for i in range(3)]
    score = learned(task_of(*experts, expert("wise", perfect)), attention=8000)
    assert score.total == pytest.approx(-0.1, abs=0.02)
    assert score.sensors["wise"] == TEST


def test_complementary_local_experts():
    """Whoever is asked first knows in half the rooms; where it does not, the other one is worth its price."""
    score = learned(task_of(expert("here", local(0)), expert("there", local(1))))
    assert score.motor.mean() > -0.02
    assert score.looks_per_step == pytest.approx(1.5, abs=0.15)


def test_a_duplicated_expert_is_asked_once():
    score = learned(task_of(expert("wise", perfect), expert("echo", perfect)))
    assert score.total == pytest.approx(-0.1, abs=0.02)
    assert score.looks.tolist()[1] == TEST


def test_an_adversary_is_as_good_as_a_friend():
    score = learned(task_of(expert("liar", adversary)))
    assert score.total == pytest.approx(-0.1, abs=0.02)


def test_an_expert_that_dies_is_no_longer_paid():
    alive = [True]
    dying = expert("wise", lambda seen: perfect(seen) if alive[0] else [0.5, 0.5])
    task = task_of(dying, expert("poor", lambda seen: [0.7, 0.3] if seen[1] == 0 else [0.3, 0.7], cost=0.3))
    mind = metal_rl.learn(task, phases=BUDGET, seed=1)
    assert mind.evaluate(task, episodes=TEST).sensors == {"wise": TEST, "poor": 0}
    alive[0] = False
    score = learned(task)
    assert score.sensors["wise"] == 0 and score.sensors["poor"] == TEST
    assert score.motor.mean() == pytest.approx(0.0, abs=0.02)


def test_a_classifier_of_scikit_learn():
    tree = pytest.importorskip("sklearn.tree")
    rng = np.random.default_rng(0)
    x = rng.integers(0, 2, (200, 3))
    classifier = tree.DecisionTreeClassifier().fit(x, x[:, 1])
    score = learned(task_of(expert("tree", classifier), expert("noise", noise)))
    assert score.total == pytest.approx(-0.1, abs=0.02)


def test_a_policy_in_the_manner_of_stable_baselines():
    class Policy:
        def predict(self, observation):
            return np.array(int(observation[1])), None

    assert learned(task_of(expert("ppo", Policy()))).total == pytest.approx(-0.1, abs=0.02)


def test_a_learning_agent_upon_an_expert():
    score = learned(task_of(expert("liar", adversary, learning=True)))
    assert score.total == pytest.approx(-0.1, abs=0.02)


def test_strange_opinions_are_refused():
    with pytest.raises(metal_rl.MetalError, match="action 7"):
        learned(task_of(expert("mad", lambda seen: 7)))
    with pytest.raises(metal_rl.MetalError, match="shares"):
        learned(task_of(expert("mad", lambda seen: [0.1, 0.2, 0.7])))
