"""Steps per second of processor time of Python environments, ours among them, as JSON. Called by `run.py`.

    environments.py ROUNDS
"""

import json
import os
import subprocess
import sys
import time

os.environ.setdefault("MUJOCO_GL", "osmesa")

import gymnasium as gym
import numpy as np

ROUNDS = int(sys.argv[1])

#: Three bodies on a plane, and the picture of one of them.
SCENE = """<mujoco><option timestep="0.01"/>
<visual><global offwidth="52" offheight="39"/></visual>
<worldbody><light pos="0 0 3"/><geom type="plane" size="5 5 0.1" rgba="0.2 0.2 0.2 1"/>%s</worldbody></mujoco>"""
BODY = """<body pos="%g 0 0.05"><freejoint/><geom type="cylinder" size="0.037 0.025" mass="0.2" rgba="1 0 0 1"/>
<camera name="eye%d" pos="0.04 0 0" xyaxes="0 -1 0 0.3 0 0.95"/></body>"""


def rate(step, steps):
    """The best of some rounds, against everything else that the machine does."""
    best = 0.0
    for _ in range(ROUNDS):
        begin = time.process_time()
        for _ in range(steps):
            step()
        best = max(best, steps / (time.process_time() - begin))
    return best


def single(env, steps):
    env.reset(seed=1)
    actions = iter(np.random.default_rng(1).integers(0, env.action_space.n, size=steps * ROUNDS).tolist())

    def step():
        _, _, terminated, truncated, _ = env.step(next(actions))
        if terminated or truncated:
            env.reset()

    return rate(step, steps)


def vector(env, steps):
    env.reset(seed=1)
    actions = np.zeros(env.num_envs, dtype=np.int64)
    return env.num_envs * rate(lambda: env.step(actions), steps)


def envpool_rate(worlds, steps):
    """CartPole-v1 in EnvPool on one thread: steps per second of processor time, that of its thread included."""
    try:
        import envpool
    except ImportError as problem:  # no wheel for this Python or machine: say so and go on
        print(f"EnvPool is not here: {problem}", file=sys.stderr)
        return float("nan")
    pool = envpool.make("CartPole-v1", env_type="gymnasium", num_envs=worlds, num_threads=1)
    pool.reset()
    actions = np.zeros(worlds, dtype=np.int32)
    return worlds * rate(lambda: pool.step(actions), steps)


def mujoco_rate(rendered):
    """Physics of three bodies, with the pictures of so many of them; not a number where nothing can be drawn."""
    try:
        import mujoco

        model = mujoco.MjModel.from_xml_string(SCENE % "".join(BODY % (0.2 * i, i) for i in range(3)))
        data = mujoco.MjData(model)
        renderer = mujoco.Renderer(model, 39, 52)
    except Exception as problem:  # no library to draw with: say so and go on
        print(f"MuJoCo cannot draw here: {problem}", file=sys.stderr)
        return float("nan")

    def step():
        mujoco.mj_step(model, data)
        for body in range(rendered):
            renderer.update_scene(data, camera=f"eye{body}")
            renderer.render()

    return rate(step, 100)


def import_seconds():
    """Seconds of `import metal_rl` less those of its own imports, gymnasium and numpy."""

    def seconds(words):
        begin = time.perf_counter()
        subprocess.run([sys.executable, "-c", words], check=True)
        return time.perf_counter() - begin

    best = {words: min(seconds(words) for _ in range(ROUNDS)) for words in ("import gymnasium", "import metal_rl")}
    return best["import metal_rl"], best["import gymnasium"]


def main():
    import metal_rl  # noqa: F401  registers our worlds
    from metal_rl.envs import MetalVectorEnv

    ours, theirs = import_seconds()
    rows = {
        "MuJoCo (drawn in software): three bodies, one picture of 52×39": mujoco_rate(1),
        "MuJoCo (drawn in software): three bodies, three pictures": mujoco_rate(3),
        "Gymnasium: CarRacing-v3, 96×96": single(gym.make("CarRacing-v3", continuous=False), 100),
        "Gymnasium: CartPole-v1": single(gym.make("CartPole-v1"), 20_000),
        "Gymnasium: 64 × CartPole-v1, its own vector in numpy": vector(gym.make_vec("CartPole-v1", 64), 300),
        "EnvPool: CartPole-v1, one world": envpool_rate(1, 5000),
        "EnvPool: 64 × CartPole-v1": envpool_rate(64, 300),
        "EnvPool: 1024 × CartPole-v1": envpool_rate(1024, 50),
        "metal_rl: Maze-v0, one world": single(gym.make("metal_rl/Maze-v0"), 20_000),
        "metal_rl: Puddle-v0, one world": single(gym.make("metal_rl/Puddle-v0"), 20_000),
        "metal_rl: Highway-v0, one world, all sensors read": single(gym.make("metal_rl/Highway-v0"), 5000),
        "metal_rl: 64 × Puddle-v0, vector": vector(MetalVectorEnv("puddle", 64), 300),
        "metal_rl: 1024 × Puddle-v0, vector": vector(MetalVectorEnv("puddle", 1024), 50),
        "metal_rl: 64 × Highway-v0, vector": vector(MetalVectorEnv("highway", 64), 100),
        "seconds of `import metal_rl`": ours,
        "seconds of `import gymnasium` alone": theirs,
    }
    print(json.dumps(rows))


if __name__ == "__main__":
    main()
