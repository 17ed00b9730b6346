"""The comparison every claim needs."""

import pytest

import metal_rl
from metal_rl import PricedSensors, Sensor
from conftest import Signpost

ROWS = {"blind", "random subset", "best static subset", "all sensors", "fusion", "METAL"}


def test_a_task_that_needs_the_light(signpost, quick):
    bench = metal_rl.bench(signpost, phases=quick, seeds=2, episodes=60, price_factors=[])
    assert set(bench.results["rows"]) == ROWS
    assert bench.total("METAL")[0] == pytest.approx(-0.1)
    assert bench.results["rows"]["best static subset"]["remark"] == "light"
    assert bench.looks("all sensors") == 2.0 and bench.looks("blind") == 0.0
    assert bench.total("blind")[0] < -0.3
    assert bench.warnings == ["fewer than 5 trainings: intervals mean little"]
    assert bench.results["front"]["metal_area"] == pytest.approx(0.5, abs=0.02)
    for row in ROWS:
        assert row in str(bench)


def test_results_become_a_table_of_episodes(tmp_path, maze):
    pd = pytest.importorskip("pandas")
    pytest.importorskip("pyarrow")
    bench = metal_rl.bench(maze, steps=300, seeds=2, episodes=4, price_factors=[])
    bench.save(tmp_path / "maze.parquet")
    bench.save(tmp_path / "maze.csv")
    frame = pd.read_parquet(tmp_path / "maze.parquet")
    pd.testing.assert_frame_equal(frame, bench.frame())
    assert len(frame) == len(pd.read_csv(tmp_path / "maze.csv")) == len(ROWS) * 2 * 4
    mine = frame[(frame.row == "METAL") & (frame.training == 1)]
    assert mine.motor_reward.tolist() == bench.results["rows"]["METAL"]["scores"][1]["motor"]
    with pytest.raises(metal_rl.MetalError, match="parquet"):
        bench.save(tmp_path / "maze.xlsx")


def test_a_task_that_needs_no_attention_says_so(quick):
    class Easy(Signpost):
        def step(self, action):
            observation, _, *end = super().step(action)
            return observation, float(action), *end

    task = PricedSensors(Easy(), [Sensor("light", 0, 0.1)])
    bench = metal_rl.bench(task, phases=quick, seeds=2, episodes=20, price_factors=[])
    assert "does not need attention" in bench.warnings[0]


def test_built_in_tasks_are_compared_on_threads_with_the_same_numbers():
    maze = metal_rl.BuiltIn("maze", side=3, goal={"x": 2, "y": 2})
    results = []
    for _ in range(2):
        bench = metal_rl.bench(maze, steps=600, seeds=2, episodes=10, price_factors=[2.0])
        rows = {name: row["scores"] for name, row in bench.results["rows"].items()}
        results.append((rows, bench.results["front"]))
    assert results[0] == results[1]


@pytest.mark.parametrize(("option", "value"), [("seeds", 0), ("exhaustive", 13), ("price_factors", [-1.0])])
def test_impossible_options_are_refused(signpost, option, value):
    with pytest.raises(metal_rl.MetalError) as refused:
        metal_rl.bench(signpost, **{option: value})
    assert refused.value.field == option
