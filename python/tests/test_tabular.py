"""Features that cost."""

import numpy as np
import pytest

import metal_rl
from metal_rl import tabular


def xor(rows=400):
    rng = np.random.default_rng(0)
    bits = rng.integers(0, 2, (rows, 2))
    return np.column_stack([bits, rng.random(rows)]), bits[:, 0] ^ bits[:, 1]


def test_two_features_that_only_tell_together_are_both_bought():
    x, y = xor()
    task = tabular.from_arrays(x, y, ["a", "b", "noise"], default_price=0.02)
    mind = metal_rl.learn(task, phases={"demonstration": 0, "fusion": 1500, "attention": 6000}, seed=1)
    score = mind.evaluate(task, episodes=300)
    assert score.motor.mean() > -0.1, "nearly always right"
    assert score.looks_per_step < 2.5


def test_frames_with_groups_words_and_holes():
    pd = pytest.importorskip("pandas")
    frame = pd.DataFrame(
        {
            "age": [1.0, np.nan, 3.0, 4.0] * 5,
            "colour": ["red", None, "blue", "red"] * 5,
            "pressure": [1, 2, 3, 4] * 5,
            "ill": ["no", "no", "yes", "yes"] * 5,
        }
    )
    task = tabular.Table(frame, "ill", groups={"visit": (["age", "colour"], 0.5)}, prices={"pressure": 0.1})
    sensors = {s["name"]: s for s in task.spec["sensors"]}
    assert task.action_names == ["no", "yes"]
    names = [f["name"] for f in sensors["visit"]["features"]]
    assert names == ["age", "age known", "colour=blue", "colour=blue known", "colour=red", "colour=red known"]
    assert sensors["pressure"]["price"] == 0.1


def test_files(tmp_path):
    pd = pytest.importorskip("pandas")
    frame = pd.DataFrame({"a": range(20), "y": [0, 1] * 10})
    frame.to_csv(tmp_path / "small.csv", index=False)
    task = tabular.read(tmp_path / "small.csv", "y")
    assert task.sensor_names == ["a"] and task.action_names == ["0", "1"]


@pytest.mark.parametrize(
    ("options", "field"),
    [
        ({"groups": {"g": (["nose"], 1.0)}}, "group.g.columns"),
        ({"default_price": -1.0}, "groups.a"),
        ({"test_share": 2.0}, "test_share"),
    ],
)
def test_impossible_tables_are_refused(options, field):
    x, y = xor(20)
    with pytest.raises(metal_rl.MetalError) as refused:
        tabular.from_arrays(x, y, ["a", "b", "c"], **options)
    assert refused.value.field == field


def test_attention_learns_from_imagined_rows_here_too():
    cube = metal_rl.BuiltIn("cube", rows=100)

    def told(imagination):
        phases = {"demonstration": 0, "fusion": 0, "attention": 200}
        mind = metal_rl.learn(cube, phases=phases, recipe={"imagination": imagination}, seed=1)
        return mind.evaluate(cube, episodes=50).motor.tolist()

    assert told(True) != told(False)


def test_the_cube_is_built_in():
    cube, context = metal_rl.BuiltIn("cube"), metal_rl.BuiltIn("cube_nm")
    assert len(cube.sensor_names) == 20 and len(cube.action_names) == 8
    assert len(context.sensor_names) == 51 and context.sensor_names[0] == "context"
