#!/usr/bin/env bash
# Inside a network namespace of its own (`unshare -n tools/judges/ros.sh PYTHON METAL METAL_ROS [RUN]`): wakes the loopback
# device, gives it multicast, which DDS finds its partners by, and lets the judge speak. Nothing leaves this machine.
set -euo pipefail
ip link set lo up
ip link set lo multicast on
ip route add 224.0.0.0/4 dev lo
export CYCLONEDDS_URI='<CycloneDDS><Domain><General><Interfaces><NetworkInterface name="lo" multicast="true"/></Interfaces></General></Domain></CycloneDDS>'
exec "$1" "$(dirname "$0")/ros.py" "${@:2}"
