#!/usr/bin/env python3
"""The client of the University of Fribourg for the e-puck2, unmodified, against `metal serve epuck2`.

    epuck2.py METAL

Its licence is the AGPL: it runs here as a separate program and nothing of it is part of METAL. It wants PyTorch and
OpenCV for pictures that nobody asks for, so those modules are mocks here; and the robot's port 1000 needs root, so
`connect` goes to the port of the server.
"""

import re
import socket
import subprocess
import sys
import tempfile
import time
import types
import unittest.mock


def fail(message):
    sys.exit(f"epuck2 judge: {message}")


def client(port):
    """The Fribourg client, connected."""
    for name in ["torch", "torchvision", "cv2", "socketio", "requests", "flask", "PIL", "PIL.Image", "tkinter"]:
        sys.modules[name] = unittest.mock.MagicMock(name=name)
    package = "unifr_api_epuck.epuck.models"
    for name, items in {"helper": ["non_max_suppression", "plot_detection"], "yolo": ["attempt_load"]}.items():
        module = types.ModuleType(f"{package}.{name}")
        for item in items:
            setattr(module, item, None)
        sys.modules[f"{package}.{name}"] = module
    connect = socket.socket.connect
    socket.socket.connect = lambda self, address: connect(self, (address[0], port))
    from unifr_api_epuck.epuck.epuck_wifi import WifiEpuck
    return WifiEpuck("127.0.0.1")


def share(red, green, blue):
    """Black, white, red and green in per cent, by the default thresholds of metal-worlds, of pixels 0 to 255."""
    counts = [0] * 4
    for r, g, b in zip(red, green, blue):
        high, low = max(r, g, b), min(r, g, b)
        if high < 0.18 * 255:
            kind = 0
        elif high - low < 0.35 * high:
            kind = 0 if high < 0.55 * 255 else 1
        elif r == high and 60 * abs(g - b) / (high - low) <= 50:
            kind = 2
        else:
            kind = 3
        counts[kind] += 1
    return [100 * c / max(1, len(red)) for c in counts]


def main():
    metal = sys.argv[1]
    server = subprocess.Popen([metal, "serve", "epuck2", "--bind", "127.0.0.1:0"], stdout=subprocess.PIPE, text=True)
    try:
        port = int(re.search(r":(\d+)", server.stdout.readline()).group(1))
        judge(metal, port)
    finally:
        server.terminate()
        server.wait()
    print("  proximity, ToF, ground, battery, steps, speed and picture agree")


def judge(metal, port):
    robot = client(port)
    robot.init_sensors()
    if not robot.go_on():
        fail("no sensors came")
    expected = {"battery": (robot.get_battery_level(), 927), "ToF": (robot.get_tof(), 2000),
                "ground": (robot.get_ground(), [500] * 3)}
    for name, (found, wanted) in expected.items():
        if found != wanted:
            fail(f"{name}: {found}, not {wanted}")
    proximity = robot.get_prox()
    if len(proximity) != 8 or max(proximity) > 40:
        fail(f"proximity of free road: {proximity}")

    # Wheels: their unit is rad/s with 800/7.536 steps each; 400 steps a second for a second.
    robot.set_speed(400 * 7.536 / 800)
    start = time.monotonic()
    while time.monotonic() - start < 1.0:
        robot.go_on()
        time.sleep(0.02)
    robot.set_speed(0)
    robot.go_on()
    elapsed = time.monotonic() - start
    robot.go_on()
    for steps in robot.get_motors_steps():
        if abs(steps - 400 * elapsed) > 40:
            fail(f"{steps} steps in {elapsed:.3f} s at 400 a second")

    # One packet is read for each command, so only the picture is asked for.
    robot.disable_sensors()
    with tempfile.TemporaryDirectory() as folder:
        robot.init_camera(folder)
        robot.go_on()
        red, green, blue = robot.get_camera()
    ours = doctor(metal, port, robot)
    # The upper left pixel of each block of the middle 156x117: near rows and the middle columns are region MN.
    rows, columns = range(1 + 3 * 13, 1 + 3 * 39, 3), range(2 + 3 * 17, 2 + 3 * 35, 3)
    pick = lambda plane: [int(plane[r][c]) for r in rows for c in columns]
    theirs = share(pick(red), pick(green), pick(blue))
    if any(abs(a - b) > 1.0 for a, b in zip(theirs, ours)):
        fail(f"colours of the middle near region: {theirs} in their eyes, {ours} in ours")


def doctor(metal, port, robot):
    """What our own client sees in the middle near region; the server serves one client after the other."""
    robot._WifiEpuck__sock.close()
    text = subprocess.run([metal, "doctor", "--robot", f"epuck2://127.0.0.1:{port}"], capture_output=True, text=True,
                          timeout=60).stdout
    found = re.search(r"MN (\d+)/(\d+)/(\d+)/(\d+)", text)
    if not found:
        fail(f"metal doctor said\n{text}")
    return [float(n) for n in found.groups()]


main()
