#!/usr/bin/env python3
"""The bytes of the robots' languages, put together from the documented layouts with nothing but `struct`: no line of METAL
has a part in it. `layouts.py > layouts.txt`; tests/goldens.rs holds the Rust modules against it.

Sources: BTcom and the advanced sercom (serial), the e-puck2's Wi-Fi firmware, and the sources of Webots R2023b and R2025a.
"""

from struct import pack


def row(name, *parts):
    print(f"{name}: {b''.join(parts).hex(' ')}")


def text(words):
    return words.encode() + b"\0"


def i16(*v):
    return pack(f"<{len(v)}h", *v)


def u16(*v):
    return pack(f"<{len(v)}H", *v)


def i32(*v):
    return pack(f"<{len(v)}i", *v)


def f32(*v):
    return pack(f"<{len(v)}f", *v)


def f64(*v):
    return pack(f"<{len(v)}d", *v)


# The E-puck's serial line: requests are the negatives of letters, a zero ends the run.
def letter(name):
    return bytes([-ord(name) & 0xFF])


LINES = [("version", "V"), ("speeds", "D,-100,1000"), ("stop", "S"), ("get speeds", "E"), ("get steps", "Q"),
         ("set steps", "P,7,-7"), ("proximity", "N"), ("ambient", "O"), ("acceleration", "A"), ("ground", "M"),
         ("calibrate", "K"), ("get camera", "I"), ("camera", "J,1,52,39,8"), ("camera window", "J,0,18,13,8,248,240"),
         ("selector", "C"), ("light", "L,3,2"), ("body", "B,1"), ("front", "F,0"), ("battery", "b")]
for name, line in LINES:
    row(f"sercom line {name}", line.encode(), b"\n")
row("sercom request", letter("D"), i16(300, -2), letter("L"), bytes([8, 1]), letter("P"), i16(-5, 6), *map(letter, "NOaAEQMugbtI"),
    bytes([0xF8]), b"\0")
row("sercom answer proximity", u16(*range(1, 9)))
row("sercom answer raw acceleration", i16(2000, 1999, -3))
row("sercom answer acceleration", f32(1.5, -2.25, 90.0))
row("sercom answer counters", i16(-2, 258))
row("sercom answer ground of the first", u16(1, 2, 3))
row("sercom answer ground of the second", u16(1, 2, 3, 4))
row("sercom answer temperature", pack("b", -7))
row("sercom answer picture", bytes([1, 2, 1]), bytes([0xF8, 0x00, 0x07, 0xE0]))

# The e-puck2: 21 bytes there, a name and a block back.
row("wifi command speeds", bytes([0x80, 0b11, 0]), i16(-300, 600), bytes([0x31]), bytes(range(1, 13)), bytes([0x20]))
row("wifi command steps", bytes([0x80, 0b10, 0b111]), i16(1, -1), bytes([0]), bytes(12), bytes([0]))
SENSORS = b"".join([
    i16(1, -2, 3), f32(4.5), f32(5.5), f32(6.5), i16(-7, 8, -9), f32(10.5, 11.5, 12.5), pack("b", -13),
    u16(*range(14, 22)), u16(*range(22, 30)), u16(30), u16(*range(31, 35)), i16(-35, 36), u16(37), bytes([38]),
    bytes([39, 40, 41]), bytes([15]), u16(42, 43, 44), u16(45, 46, 47), bytes([1]), bytes([0])])
assert len(SENSORS) == 104
row("wifi answer sensors", b"\2", SENSORS)
row("wifi answer nothing", b"\3")

# Webots.
row("webots hello", b"CTR")
row("webots hello by name", b"CTR\nRobot-Name: my%20robot")
for word in ["CONNECTED", "FAILED", "PROCESSING", "FORBIDDEN"]:
    row(f"webots welcome {word}", word.encode())
orders = u16(1) + i32(10) + u16(2) + f64(2.5) + u16(21) + i32(3) + b"\1" + u16(32)
row("webots request", pack("<II", 8 + len(orders), 32), orders)
row("webots goodbye", i32(0))
news = u16(0) + b"\4" + f64(0.064)
row("webots answer", u16(2), i32(4 + len(news)), i32(4 + len(news)), b"\0", i32(-1), news,
    i32(4), b"\1", u16(21), b"\0", bytes([3, 2, 1, 255]))
row("webots reading distance", u16(3), bytes([50]), f64(67.19))
row("webots reading light", u16(4), bytes([55]), f64(3.0))
row("webots reading position", u16(5), bytes([1]), f64(0.5))
row("webots reading acceleration", u16(6), bytes([51]), f64(0, 0, 9.81))
row("webots reading gyro", u16(7), bytes([53]), f64(1, 2, 3))

TABLE = [(0.0, 4095.0, 0.002), (0.07, 67.19, 0.04897)]
table = i32(len(TABLE)) + b"".join(f64(*line) for line in TABLE)
DEVICES = [
    (57, "left wheel motor", i32(0) + f64(0, 0, 7.536, -1, 10, 10, 0, 0, 0, 7.536, 1) + i32(1) + u16(2)),
    (52, "left wheel sensor", i32(0)),
    (42, "ps0", i32(1) + f64(67, 4095, 0.1) + table),
    (49, "ls0", table),
    (38, "camera", i32(17) + u16(52, 39) + f64(0.84, 0.0055) + b"\1" + f64(0.84, 0.84) + b"\0\1" + f64(1, 2, 3, 4, 5)),
    (47, "led0", None),
    (35, "accelerometer", table),
    (45, "gyro", i32(0)),
    (56, "receiver", i32(4096, 1, 2, 1, 2)),
    (43, "emitter", i32(-1, 1) + f64(1e4, 1, -1) + i32(0)),
    (59, "speaker", None),
]
for release in ["R2023b", "R2025a"]:
    newer = release == "R2025a"
    robot = [u16(0), b"\0", text("learner"), text(release), b"\1\1", u16(1 + len(DEVICES), 34), f64(0.25)]
    robot += [u16(node) + text(name) + text("") for node, name, _ in DEVICES]
    robot += [f64(32.0)] + [text(t) for t in ["p", "w", "m", "<none>", "r", "<extern>", "d"]] + [b"\0\1", i32(2)]
    # The supervisor's own node; R2025a says its ancestor among the PROTOs before the model.
    robot += [u16(0), b"\0", i32(7, 1), b"\1\0"] + ([i32(-1)] if newer else []) + [text("e-puck"), text("LEARNER")]
    robot += [u16(tag) + b"\0" + said for tag, (_, _, said) in enumerate(DEVICES, 1) if said is not None]
    row(f"webots {release} configure", *robot)

    node = i32(101, 34, 0, 1) + b"\1"
    ancestor = i32(-1) if newer else b""
    row(f"webots {release} wish node by def", bytes([84]), text("RED1"), i32(-1))
    row(f"webots {release} wish node by id", bytes([83]), i32(101))
    row(f"webots {release} wish field", bytes([87]), i32(101), ancestor, text("translation"), b"\0")
    row(f"webots {release} wish get", bytes([88]), i32(101, 0), b"\0")
    row(f"webots {release} wish set place", bytes([62]), i32(101, 0, 5, -1), f64(1, 2, 0))
    row(f"webots {release} wish set rotation", bytes([62]), i32(101, 1, 6, -1), f64(0, 0, 1, 1.5))
    row(f"webots {release} wish position", bytes([90]), i32(101))
    row(f"webots {release} wish orientation", bytes([91]), i32(101))
    row(f"webots {release} wish pose", bytes([92]), i32(0, 101))
    row(f"webots {release} wish velocity", bytes([96]), i32(101))
    row(f"webots {release} wish set velocity", bytes([66]), i32(101), f64(1, 2, 3, 4, 5, 6))
    row(f"webots {release} wish reset physics", bytes([67]), i32(101))
    row(f"webots {release} wish restart controller", bytes([68]), i32(101))
    row(f"webots {release} wish track", bytes([102]), i32(0, 101), b"\1", i32(32))
    row(f"webots {release} wish track no longer", bytes([102]), i32(0, 101), b"\0")
    row(f"webots {release} wish reset", bytes([55]))
    row(f"webots {release} wish mode", bytes([56]), i32(2))
    row(f"webots {release} wish quit", bytes([54]), i32(0))
    row(f"webots {release} fact node by def", bytes([84]), node, ancestor, text("e-puck"))
    row(f"webots {release} fact node by id", bytes([83]), node, b"\0", text("e-puck"), text("RED1"), ancestor)
    row(f"webots {release} fact field", bytes([87]), i32(0, 5), b"\0", i32(-1), text("translation"))
    row(f"webots {release} fact value", bytes([88]), i32(5, 101, 0), f64(1, 2, 0))
    row(f"webots {release} fact position", bytes([90]), f64(1, 2, 0))
    row(f"webots {release} fact orientation", bytes([91]), f64(*range(9)))
    row(f"webots {release} fact pose", bytes([92]), i32(0, 101), f64(*range(16)))
    row(f"webots {release} fact velocity", bytes([96]), f64(*range(6)))
