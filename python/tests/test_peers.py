"""Peers learn on the very tasks METAL learns, and pay for what they read."""

import numpy as np
import pytest

import metal_rl
from metal_rl import compare, peers
from metal_rl.tabular import from_arrays


def table():
    """Two columns: the first is the class itself, the second noise that costs as much."""
    rng = np.random.default_rng(0)
    y = rng.integers(2, size=120)
    x = np.stack([y + 0.1 * rng.normal(size=120), rng.normal(size=120)], axis=1)
    return from_arrays(x, y, ["tells", "noise"], default_price=0.1)


def test_all_rows_are_found_once():
    x, y = peers.examples(table())
    test_x, _ = peers.examples(table(), testing=True)
    assert (len(x), len(test_x)) == (90, 30)
    assert ((x[:, 0] > 0.5) == (y == 1)).all()


def test_only_tables_have_rows():
    with pytest.raises(metal_rl.MetalError, match="task"):
        peers.examples(metal_rl.BuiltIn("maze"))


def test_cart_pays_for_distinct_groups_only():
    pytest.importorskip("sklearn")
    smallest, *others = peers.trees(table(), seed=0)
    assert smallest.name == "CART, 2 leaves"
    assert smallest.motor == 0.0 and smallest.looks == 1.0 and smallest.cost == pytest.approx(0.1)
    assert all(tree.looks <= 2.0 for tree in others)


def test_the_forest_buys_the_best_group_first():
    pytest.importorskip("sklearn")
    one, two, *_ = peers.forests(table(), seed=0)
    assert one.motor == 0.0 and one.looks == 1.0 and two.cost == pytest.approx(0.2)


def test_the_cost_dqn_learns_to_buy_what_tells():
    result = peers.reinforcement("cost DQN", table(), 4000, seed=1, episodes=200)
    assert result.total > -0.25, "better than guessing (-0.5) and than buying everything (-0.2) is near"
    assert result.looks >= 0.9


@pytest.mark.parametrize("name", ["PPO", "DQN", "MaskablePPO"])
def test_stable_baselines_learns_within_the_budget(name):
    pytest.importorskip("stable_baselines3")
    pytest.importorskip("sb3_contrib")
    result = peers.reinforcement(name, table(), 300, seed=1, episodes=20)
    assert -1.0 <= result.motor <= 0.0 and 0.0 <= result.looks <= 5.0


def test_middles_of_trainings():
    assert compare.interquartile_mean(np.array([0.0, 1.0, 2.0, 9.0])) == 1.5
    middle, low, high = compare.estimate([1.0, 2.0, 3.0, 4.0, 5.0])
    assert low < middle < high and middle == pytest.approx(3.0)


def test_the_comparison_is_a_table(capsys):
    compare.main(["maze", "--steps", "60", "--seeds", "2", "--episodes", "3", "--who", "cost DQN"])
    head, rule, row = capsys.readouterr().out.splitlines()
    assert head.count("|") == rule.count("|") == row.count("|") and row.startswith("| cost DQN | ")
