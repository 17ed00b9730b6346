#!/usr/bin/env python3
"""Two readers that other people wrote, on a recording of ours: mcap-ros2-support and rosbags.

    recordings.py FILE.mcap
"""

import sys
from collections import Counter

import numpy
from mcap_ros2.reader import read_ros2_messages
from rosbags.typesys import Stores, get_typestore


def fail(message):
    sys.exit(f"recordings judge: {message}")


def first(path):
    """Topic, kind of message, numbers, as mcap-ros2-support reads them."""
    for m in read_ros2_messages(path):
        data = numpy.frombuffer(bytes(m.ros_msg.data), numpy.uint8) if m.schema.name.endswith(("Image", "UInt8MultiArray")) \
            else numpy.array(m.ros_msg.data)
        yield m.channel.topic, m.schema.name, data


def second(path):
    """The same, as the deserializer of rosbags reads the bytes."""
    from mcap.reader import make_reader
    store = get_typestore(Stores.ROS2_HUMBLE)
    with open(path, "rb") as file:
        for schema, channel, message in make_reader(file).iter_messages():
            found = store.deserialize_cdr(message.data, schema.name)
            yield channel.topic, schema.name, numpy.asarray(found.data)


def main():
    path, count = sys.argv[1], Counter()
    for a, b in zip(first(path), second(path), strict=True):
        if a[:2] != b[:2] or not numpy.array_equal(a[2], b[2]):
            fail(f"the readers disagree about {a[0]}")
        count[a[0]] += 1
        if a[0] == "/image_raw" and len(a[2]) != 52 * 39 * 3:
            fail(f"a picture of {len(a[2])} bytes")
        if a[0] == "/sensor/MN" and abs(sum(a[2]) - 1.0) > 1e-9:
            fail(f"shares of colours that sum to {sum(a[2])}")
    wanted = ["/phase", "/episode", "/step", "/attention", "/measures", "/sensor/IR", "/image_raw", "/supports/0", "/costs"]
    for topic in wanted:
        if not count[topic]:
            fail(f"{topic} is missing")
    print(f"  {sum(count.values())} messages on {len(count)} topics read alike by both readers")


main()
