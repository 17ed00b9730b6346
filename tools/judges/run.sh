#!/usr/bin/env bash
# Judges of the bodies that other people wrote: each drives one of our servers, or does what our simulator does, and the
# two must agree. On a fresh Debian, as root, it installs what is missing. One argument: only that judge
# (epuck2, webots, enki, recordings, worlds).
set -euo pipefail
cd "$(dirname "$0")/../.."
only=${1:-all}
target=${CARGO_TARGET_DIR:-target}
wants() { [ "$only" = all ] || [ "$only" = "$1" ]; }

install() {
    if [ "$(id -u)" -ne 0 ] || ! command -v apt-get > /dev/null; then
        echo "missing; on Debian, as root: apt-get install $*" >&2
        exit 1
    fi
    apt-get update -qq
    DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "$@" > /dev/null
}

# What Debian has to give: only for the judges that are wanted.
missing=()
if wants webots; then
    command -v rsync > /dev/null || missing+=(rsync)
    command -v make > /dev/null || missing+=(make)
    command -v clang > /dev/null || missing+=(clang)
    ls /usr/lib/llvm-*/lib/libclang*.so* > /dev/null 2>&1 || missing+=(libclang-dev)
fi
if wants enki; then
    /usr/bin/python3 -c 'import pyenki' 2> /dev/null || missing+=(python3-enki2)
fi
[ ${#missing[@]} -eq 0 ] || install "${missing[@]}"

# The Python judges live in an environment of their own. The e-puck2 client comes without its dependencies: it would
# like a whole deep-learning stack that the judge does not touch.
if wants epuck2 || wants recordings; then
    wanted=$(cat tools/judges/requirements.txt)
    if [ "$(cat .venv/judges/installed 2> /dev/null)" != "$wanted" ]; then
        python3 -m venv .venv/judges
        .venv/judges/bin/pip install --quiet --disable-pip-version-check -r tools/judges/requirements.txt
        .venv/judges/bin/pip install --quiet --disable-pip-version-check --no-deps unifr-api-epuck==1.3.11
        echo "$wanted" > .venv/judges/installed
    fi
fi

if wants epuck2; then
    echo "judge: unifr-api-epuck 1.3.11 against metal serve epuck2"
    cargo build --quiet -p metal-cli
    .venv/judges/bin/python tools/judges/epuck2.py "$target/debug/metal"
fi
if wants recordings; then
    echo "judge: mcap-ros2-support and rosbags on a recording of ours"
    cargo run --quiet -p metal-recording --example demonstration -- "$target/demonstration.mcap"
    .venv/judges/bin/python tools/judges/recordings.py "$target/demonstration.mcap"
fi
if wants worlds; then
    echo "judge: webots-proto on the world that we write"
    # Its JavaScript engine for templates is large, so it is a package of its own.
    cargo run --quiet --manifest-path tools/judges/worlds/Cargo.toml --target-dir "$target/judges"
fi
if wants enki; then
    echo "judge: Enki against our kinematics, contacts and infra-red ring"
    cargo build --quiet -p metal-robots --example paths
    /usr/bin/python3 tools/judges/enki.py "$target/debug/examples/paths" docs/images/enki.svg
fi
if wants webots; then
    echo "judge: libController of Webots R2023b against metal serve webots"
    # A package of its own, so that nobody else has to build Webots' library.
    cargo build --quiet --manifest-path tools/judges/webots/Cargo.toml --target-dir "$target/judges"
    library=$(find "$target/judges" -path '*/out/webots/lib/controller' -type d | head -n 1)
    LD_LIBRARY_PATH="$library" "$target/judges/debug/webots-judge"
fi
echo "the judges agree"
