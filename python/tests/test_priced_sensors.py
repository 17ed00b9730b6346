"""Any Gymnasium environment as a task."""

import gymnasium as gym
import numpy as np
import pytest
from gymnasium import spaces
from gymnasium.utils.env_checker import check_env

import metal_rl
from conftest import Signpost
from metal_rl import Grid, PricedSensors, Sensor, SensorCostEnv


def test_the_light_is_worth_its_price_and_the_clock_is_not(signpost, quick):
    mind = metal_rl.learn(signpost, phases=quick, seed=1)
    score = mind.evaluate(signpost, episodes=200)
    assert score.total == pytest.approx(-0.1), "reads the light, opens the right door"
    assert score.sensors == {"light": 200, "clock": 0}
    assert score.looks.tolist() == [0, 200, 0]


def test_an_unread_sensor_is_never_called(quick):
    env, called = Signpost(), {"light": 0, "laser": 0}

    def light(env):
        called["light"] += 1
        return env.unwrapped.right

    def laser(env):
        called["laser"] += 1
        return 0.5

    sensors = [Sensor("light", light, 0.1, 0, 1), Sensor("laser", laser, 2.0, 0, 1)]
    task = PricedSensors(env, sensors)
    mind = metal_rl.learn(task, phases=quick, seed=2)
    called.update(light=0, laser=0)
    score = mind.evaluate(task, episodes=50)
    assert called == {"light": 50, "laser": 0}
    assert score.sensors == called


def test_a_mind_acts_with_nothing_but_a_reader(signpost, quick, tmp_path):
    path = tmp_path / "mind.safetensors"
    learned = metal_rl.learn(signpost, phases=quick, seed=1)
    score = learned.evaluate(signpost, episodes=20)
    learned.save(path, score, remark="abc")
    mind = metal_rl.load(path)
    assert mind.notes["remark"] == "abc" and mind.seed == 1
    assert float(mind.notes["total"]) == pytest.approx(score.total) and mind.notes["episodes"] == "20"
    card = metal_rl.card(path)
    assert card["notes"] == mind.notes and card["spec"]["id"] == "Signpost-v0" and card["git"]
    assert card["recipe"]["attention"] == quick["attention"]
    (tmp_path / "other").write_bytes(b"no mind at all")
    with pytest.raises(metal_rl.MetalError, match="no card"):
        metal_rl.card(tmp_path / "other")
    asked = []

    def reader(name):
        asked.append(name)
        return [1.0]

    decision = mind.act(reader)
    assert asked == ["light"] == list(decision.consulted)
    assert decision.name == "right" and decision.cost == pytest.approx(0.1)
    assert mind.act(lambda name: 0.0).name == "left"


def test_the_same_seed_gives_the_same_mind(signpost, quick, tmp_path):
    files = []
    for run in range(2):
        metal_rl.learn(signpost, phases=quick, seed=7).save(tmp_path / f"{run}")
        files.append((tmp_path / f"{run}").read_bytes())
    assert files[0] == files[1]


def test_a_reader_that_fails_says_so_itself(signpost, quick):
    mind = metal_rl.learn(signpost, phases=quick, seed=1)
    with pytest.raises(KeyError, match="light"):
        mind.act({}.__getitem__)
    with pytest.raises(metal_rl.MetalError, match="2 numbers, but 1"):
        mind.act(lambda name: [1.0, 2.0])


def test_exceptions_of_the_environment_come_back_as_they_were(quick):
    class Broken(Signpost):
        def step(self, action):
            raise OSError("the motor is off")

    task = PricedSensors(Broken(), [Sensor("light", 0, 0.1)])
    with pytest.raises(OSError, match="the motor is off"):
        metal_rl.learn(task, phases=quick)


def test_sensors_of_every_kind():
    class Rich(gym.Env):
        observation_space = spaces.Dict(
            {"pose": spaces.Box(-1, 1, (3,)), "camera": spaces.Box(0, 255, (4, 6), np.uint8)}
        )
        action_space = spaces.Box(-1, 1, (2,))

        def reset(self, *, seed=None, options=None):
            super().reset(seed=seed)
            return self._see(), {}

        def step(self, action):
            return self._see(), float(action.sum()), False, False, {}

        def _see(self):
            picture = self.np_random.integers(0, 256, (4, 6), dtype=np.uint8)
            return {"pose": np.zeros(3, np.float32), "camera": picture}

    sensors = [
        Sensor("pose", "pose", 0.1),
        Sensor("left", "camera", 0.5, [0], [255], feature=lambda image: image[:, :3].mean()),
        Sensor("time", lambda env: 1.0, 0.0, 0, 2),
    ]
    task = PricedSensors(Rich(), sensors, actions=Grid(3))
    assert [len(s["features"]) for s in task.spec["sensors"]] == [3, 1, 1]
    assert len(task.action_names) == 9 and task.action_names[0] == "[-1 -1]"
    world = task.world()
    world.reset(0)
    assert world.step(8) == (2.0, 0)
    check_env(SensorCostEnv(task), skip_render_check=True)


def test_a_region_of_an_image():
    class Camera(gym.Env):
        observation_space = spaces.Box(0, 255, (4, 6), np.uint8)
        action_space = spaces.Discrete(2)

        def reset(self, *, seed=None, options=None):
            super().reset(seed=seed)
            return np.arange(24, dtype=np.uint8).reshape(4, 6), {}

        def step(self, action):
            return self.reset()[0], 0.0, True, False, {}

    task = PricedSensors(Camera(), [Sensor("corner", (slice(0, 2), slice(4, 6)), 1.0)])
    world = task.world()
    world.reset(0)
    assert world.sense(0).tolist() == [4, 5, 10, 11]


def test_unbounded_readings_get_a_range_from_a_random_drive():
    task = PricedSensors(gym.make("CartPole-v1"), [Sensor("speed", 1, 0.05), Sensor("angle", 2, 0.05)])
    (speed,), (angle,) = ([(f["low"], f["high"]) for f in s["features"]] for s in task.spec["sensors"])
    assert -10 < speed[0] < -1 and 1 < speed[1] < 10
    assert angle == pytest.approx((-0.4189, 0.4189), abs=1e-3)
    assert task.spec["horizon"] == 500


def test_missing_readings_are_told_apart_from_numbers():
    task = PricedSensors(Signpost(), [Sensor("sonar", lambda env: np.nan, 0.1, 0, 4, missing=True)])
    world = task.world()
    world.reset(0)
    assert world.sense(0).tolist() == [2.0, 0.0]
    unprepared = PricedSensors(Signpost(), [Sensor("sonar", lambda env: np.nan, 0.1, 0, 4)])
    with pytest.raises(metal_rl.MetalError, match="missing=True") as refused:
        metal_rl.learn(unprepared, phases={"fusion": 10, "attention": 10})
    assert refused.value.field == "sensors.sonar"


@pytest.mark.parametrize(
    ("build", "field"),
    [
        (lambda: Sensor("a", 0, cost=-1.0), "sensors.a.cost"),
        (lambda: PricedSensors(Signpost(), []), "sensors"),
        (lambda: PricedSensors(Signpost(), [Sensor("a", 0), Sensor("a", 1)]), "sensors"),
        (lambda: PricedSensors(Signpost(), [Sensor("a", 7)]), "sensors.a.source"),
        (lambda: PricedSensors(Signpost(), [Sensor("a", 0)], actions=[0, 5]), "actions.5"),
        (lambda: PricedSensors(gym.make("Pendulum-v1"), [Sensor("a", 0)]), "actions"),
        (lambda: PricedSensors(gym.make("Pendulum-v1"), [Sensor("a", 0)], actions=Grid(99)), "actions"),
        (lambda: metal_rl.BuiltIn("moon"), "environment.moon"),
        (lambda: metal_rl.BuiltIn("maze", sides=4), "environment.maze"),
        (lambda: metal_rl.BuiltIn("puddle", horizon=0), "puddle.horizon"),
    ],
)
def test_what_cannot_be_used_is_refused_with_its_field(build, field):
    with pytest.raises(metal_rl.MetalError) as refused:
        build()
    assert refused.value.field == field
    assert field.split(".")[-1] in str(refused.value)


@pytest.mark.parametrize(
    ("arguments", "match"),
    [
        ({"phases": {"dreaming": 3}}, "dreaming"),
        ({"phases": ["fusion"]}, "attention"),
        ({"recipe": {"gama": 1}}, "gama"),
        ({"recipe": {"credit": {"gamma": 1.5, "lambda": 0.5}}}, "1.5"),
    ],
)
def test_impossible_recipes_are_refused(signpost, arguments, match):
    with pytest.raises(metal_rl.MetalError, match=match):
        metal_rl.learn(signpost, **arguments)


@pytest.mark.parametrize(
    ("phases", "budgets"),
    [
        (None, (200, 0, 600)),
        (["attention"], (0, 0, 600)),
        (["fusion", "attention"], (0, 200, 400)),
        ({"attention": 90}, (200, 0, 90)),
    ],
)
def test_steps_are_shared_among_the_phases_that_take_place(signpost, phases, budgets):
    recipe = metal_rl.learn(signpost, steps=600, phases=phases).recipe
    assert (recipe["demonstration"], recipe["fusion"], recipe["attention"]) == budgets


def test_a_sensor_may_not_take_the_observers_name(quick):
    task = PricedSensors(Signpost(), [Sensor("FOA", 0, 0.1)])
    with pytest.raises(metal_rl.MetalError, match="full observer"):
        metal_rl.learn(task, phases=quick)


def test_an_expert_is_watched_first():
    asked = []

    def expert(env):
        asked.append(1)
        return env.unwrapped.right

    task = PricedSensors(Signpost(), [Sensor("light", 0, 0.1), Sensor("clock", 1, 0.1)], expert=expert)
    mind = metal_rl.learn(task, phases={"demonstration": 40, "fusion": 300, "attention": 1500})
    assert len(asked) >= 40
    assert mind.evaluate(task, driver="expert").total == 0.0


def test_an_expert_that_is_not_there_cannot_drive(signpost):
    mind = metal_rl.learn(signpost, phases={"fusion": 10, "attention": 10})
    with pytest.raises(metal_rl.MetalError, match="no expert"):
        mind.evaluate(signpost, driver="expert")
    with pytest.raises(metal_rl.MetalError, match="nobody"):
        mind.evaluate(signpost, driver="nobody")


def test_a_check_says_what_is_badly_posed(signpost):
    found = metal_rl.check(signpost, steps=1500)
    assert found.blind["left"] == pytest.approx(-0.5, abs=0.3) and not found.problems
    assert found.alone["light"] > -0.1 > found.alone["clock"], "only the light tells the door"
    assert found.everything > -0.1 and "light alone" in " ".join(found.warnings)
    assert found.bits["light"] == pytest.approx(1.0, abs=0.2) and found.bits["clock"] > 2.0
    still = PricedSensors(Signpost(), [Sensor("wall", lambda env: 1.0, 9.0, 0, 2)])
    problems = " ".join(metal_rl.check(still, steps=20).problems)
    assert "never changes" in problems and "costs 9" in problems
    with pytest.raises(metal_rl.MetalError, match="episodes"):
        metal_rl.check(signpost, episodes=0)


def test_a_critic_learns_a_python_environment(signpost):
    phases = {"demonstration": 0, "fusion": 0, "attention": 2000}
    mind = metal_rl.learn(signpost, phases=phases, recipe={"method": "critic"}, seed=1)
    assert "critic" in mind.recipe["method"]["counterfactual"]["judge"]
    score = mind.evaluate(signpost, episodes=100)
    assert score.motor.mean() > -0.1 and score.sensors["light"] > 80
