"""Many trainings, with the same results wherever they run."""

import numpy as np
import pytest

import metal_rl
from metal_rl import Plan, sweep

LEARN = {"phases": {"demonstration": 0, "fusion": 100, "attention": 200}}


def maze():
    return metal_rl.BuiltIn("maze")


def by_seed(runs):
    return {(run.plan, run.seed): run.score for run in runs}


def same(one, other):
    return one.keys() == other.keys() and all(
        np.array_equal(one[k].motor, other[k].motor) and one[k].sensors == other[k].sensors for k in one
    )


def test_threads_change_nothing():
    plans = [Plan(maze, LEARN, 5, "short"), Plan(maze, {**LEARN, "recipe": {"learn_on": True}}, 5, "on")]
    many, one = sweep(plans, seeds=range(3), workers=3), sweep(plans, seeds=range(3), workers=1)
    many, one = by_seed(many), by_seed(one)
    assert len(many) == 6 and same(many, one)


def test_a_run_that_fails_is_tried_again():
    failures = [OSError("the link broke"), OSError("and again")]

    def flaky():
        if failures:
            raise failures.pop()
        return maze()

    assert len(list(sweep(Plan(flaky, LEARN, 5), seeds=[1]))) == 1
    with pytest.raises(metal_rl.MetalError, match="moon"):
        list(sweep(Plan(lambda: metal_rl.BuiltIn("moon"), LEARN), seeds=[1]))


def test_elsewhere_is_refused():
    with pytest.raises(metal_rl.MetalError, match="threads or ray"):
        sweep(Plan(maze, LEARN), [1], on="mars")


@pytest.mark.cluster
def test_a_node_that_dies_changes_nothing():
    """A local Ray cluster of two nodes, one of which is killed while the sweep runs."""
    ray = pytest.importorskip("ray")
    utilities = pytest.importorskip("ray.cluster_utils")
    plan = Plan(maze, {"phases": {"demonstration": 0, "fusion": 300, "attention": 6000}}, 5)
    cluster = utilities.Cluster(initialize_head=True, head_node_args={"num_cpus": 1})
    try:
        doomed = cluster.add_node(num_cpus=1)
        ray.init(address=cluster.address)
        cluster.wait_for_nodes()
        runs = []
        for run in sweep(plan, seeds=range(6), on="ray"):
            runs.append(run)
            if doomed is not None:
                cluster.remove_node(doomed, allow_graceful=False)
                doomed = None
    finally:
        ray.shutdown()
        cluster.shutdown()
    assert same(by_seed(runs), by_seed(sweep(plan, seeds=range(6))))
