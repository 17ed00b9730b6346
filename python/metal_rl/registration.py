"""The built-in worlds under their Gymnasium names. A change of dynamics is a new version."""

from gymnasium.envs.registration import register as register_env
from gymnasium.envs.registration import registry

#: Gymnasium's name of every built-in world, and ours.
WORLDS = {
    "metal_rl/Highway-v0": "highway",
    "metal_rl/Maze-v0": "maze",
    "metal_rl/Puddle-v0": "puddle",
    "metal_rl/Toy-v0": "toy",
    "metal_rl/Cube-v0": "cube",
    "metal_rl/CubeNM-v0": "cube_nm",
}


def register() -> None:
    """Makes the built-in worlds known; `import metal_rl` calls this."""
    for name, world in WORLDS.items():
        if name not in registry:
            register_env(
                name,
                entry_point="metal_rl.envs:MetalEnv",
                vector_entry_point="metal_rl.envs:MetalVectorEnv",
                kwargs={"name": world},
            )
