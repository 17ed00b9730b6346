"""Rust works without the interpreter, hears Ctrl-C, and is typed."""

import ast
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import metal_rl
from metal_rl import _core

LONG = "import metal_rl; print('on', flush=True); metal_rl.learn(metal_rl.BuiltIn('maze'), steps=50_000_000)"


def test_ctrl_c_is_heard():
    # As in a terminal: children of a shell's background jobs begin with the signal ignored.
    heard = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler); "
    worker = subprocess.Popen([sys.executable, "-c", heard + LONG], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert worker.stdout.readline() == "on\n"
    time.sleep(0.5)
    worker.send_signal(signal.SIGINT)
    _, complaint = worker.communicate(timeout=30)
    assert worker.returncode != 0 and "KeyboardInterrupt" in complaint


def test_python_goes_on_while_rust_learns():
    maze = metal_rl.BuiltIn("maze")
    learning = threading.Thread(target=metal_rl.learn, args=(maze,), kwargs={"steps": 3000})
    learning.start()
    turns = 0
    while learning.is_alive():
        time.sleep(0.001)
        turns += 1
    assert turns > 10


def test_stubs_name_what_there_is():
    stubs = ast.parse((Path(_core.__file__).parent / "_core.pyi").read_text())
    told = {node.name: node for node in stubs.body if isinstance(node, (ast.ClassDef, ast.FunctionDef))}
    there = {name for name in dir(_core) if not name.startswith("_")}
    assert set(told) == there
    for name, node in told.items():
        if isinstance(node, ast.ClassDef) and name != "MetalError":
            methods = {m.name for m in node.body if isinstance(m, ast.FunctionDef)} - {"__init__"}
            real = {m for m in vars(getattr(_core, name)) if not m.startswith("_")}
            assert methods == real, name
    assert (Path(metal_rl.__file__).parent / "py.typed").exists()


def test_everything_offered_is_there():
    assert all(hasattr(metal_rl, name) for name in metal_rl.__all__)
