"""METAL: learn a control task together with which priced sensors to consult before each action.

In ten lines: wrap a Gymnasium environment in `PricedSensors`, `learn` it, and see with `bench` whether attention pays.
"""

from metal_rl._core import MetalError, __version__
from metal_rl.actions import Grid
from metal_rl.bench import Bench, bench
from metal_rl.check import Check, check
from metal_rl.envs import MetalEnv, MetalVectorEnv
from metal_rl.experts import Expert
from metal_rl.minds import Decision, Mind, Score, card, learn, load
from metal_rl.priced import PricedSensors
from metal_rl.registration import register
from metal_rl.sensor_cost import SensorCostEnv
from metal_rl.sensors import Sensor
from metal_rl.shown import Demonstration, read_demonstration
from metal_rl.sweep import Plan, Run, sweep
from metal_rl.tasks import BuiltIn, Task

__all__ = [
    "Bench",
    "BuiltIn",
    "Check",
    "Decision",
    "Demonstration",
    "Expert",
    "Grid",
    "MetalEnv",
    "MetalError",
    "MetalVectorEnv",
    "Mind",
    "Plan",
    "PricedSensors",
    "Run",
    "Score",
    "Sensor",
    "SensorCostEnv",
    "Task",
    "__version__",
    "bench",
    "card",
    "check",
    "learn",
    "load",
    "read_demonstration",
    "sweep",
]

register()
