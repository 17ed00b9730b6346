"""Files of the studio: tests/data/shown.jsonl was made by a person's presses in `metal studio`."""

import json
from pathlib import Path

import numpy as np
import pytest

from metal_rl import MetalError, read_demonstration

FILE = Path(__file__).parent / "data" / "shown.jsonl"


def test_a_demonstration_of_the_studio_is_arrays():
    shown = read_demonstration(FILE)
    assert shown.environment == "Highway-v0"
    assert list(shown.sensors) == ["MN", "LN", "RN", "MF", "LF", "RF", "IR"]
    assert shown.sensors["RN"] == ["black", "white", "red", "green"] and shown.prices["MN"] == 1.5
    first, second = shown
    assert shown.steps == 5 and len(first) == 3 and first.actions.tolist() == [0, 1, 2] and second.actions.tolist() == [0, 3]
    assert first.observations["IR"].shape == (4, 8), "the cut episode closes with a last look"
    assert np.allclose(first.observations["MN"].sum(axis=1), 1.0)
    assert first.truncations.tolist() == [False, False, True] and not first.terminations.any()
    assert first.rewards.dtype == float and first.accidents.dtype == bool and set(first.advice) <= set(range(-1, 5))


@pytest.mark.parametrize(
    ("line", "change", "said"),
    [
        (0, {"metal_demonstrations": 9}, "line 1, metal_demonstrations: 9"),
        (0, {"sensors": []}, "line 1, sensors"),
        (1, {"action": 7}, "line 2, action: 7: there are 5"),
        (2, {"readings": [[1.0]]}, "line 3, readings: lengths"),
        (2, {"readings": "dark"}, "line 3, readings: 'dark'"),
        (3, {"end": "Later"}, "line 4, end: 'Later'"),
        (1, {"motor_reward": "much"}, "line 2, motor_reward: 'much'"),
        (1, {"episode": True}, "line 2, episode: True"),
    ],
)
def test_damage_is_named(tmp_path, line, change, said):
    rows = [json.loads(row) for row in FILE.read_text().splitlines()]
    rows[line].update(change)
    file = tmp_path / "bad.jsonl"
    file.write_text("\n".join(json.dumps(row) for row in rows))
    with pytest.raises(MetalError) as refused:
        read_demonstration(file)
    assert str(file) in str(refused.value) and said in str(refused.value)


def test_what_is_no_json_or_not_there_is_refused(tmp_path):
    file = tmp_path / "cut.jsonl"
    file.write_text(FILE.read_text()[:-20])
    with pytest.raises(MetalError, match="line 8: no JSON|line 7: no JSON"):
        read_demonstration(file)
    file.write_text("")
    with pytest.raises(MetalError, match="empty"):
        read_demonstration(file)
    with pytest.raises(OSError):
        read_demonstration(tmp_path / "nowhere.jsonl")
