#!/usr/bin/env bash
# Judges of the bodies that other people wrote: each drives one of our servers, or does what our simulator does, and the
# two must agree. On a fresh Debian, as root, it installs what is missing. Arguments: only that judge (epuck2, recordings,
# worlds, enki, webots, ros; all by default), and a folder that `metal reproduce` wrote, for the judge that listens to a
# mind (without one it trains a small one). No judge takes longer than its time-out; building is outside of it.
set -euo pipefail
cd "$(dirname "$0")/../.."
only=${1:-all}
run=${2:-}
target=${CARGO_TARGET_DIR:-target}
target=$(mkdir -p "$target" && cd "$target" && pwd)
wants() { [ "$only" = all ] || [ "$only" = "$1" ]; }
case $only in all | epuck2 | recordings | worlds | enki | webots | ros) ;; *) echo "no judge is called $only" >&2; exit 1 ;; esac

# Runs a judge, for so many seconds at most, and says how long it took.
judge() {
    local name=$1 seconds=$2 start=$SECONDS
    shift 2
    echo "judge: $name"
    timeout --kill-after=10 "$seconds" "$@" || { echo "judge: $name: failed or took over $seconds s ($?)" >&2; exit 1; }
    echo "  $((SECONDS - start)) s"
}

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
if wants ros; then
    command -v ip > /dev/null || missing+=(iproute2)
fi
[ ${#missing[@]} -eq 0 ] || install "${missing[@]}"

# The Python judges live in an environment of their own. The e-puck2 client comes without its dependencies: it would
# like a whole deep-learning stack that the judge does not touch.
if wants epuck2 || wants recordings || wants ros; then
    wanted=$(cat tools/judges/requirements.txt)
    if [ "$(cat .venv/judges/installed 2> /dev/null)" != "$wanted" ]; then
        python3 -m venv .venv/judges
        .venv/judges/bin/pip install --quiet --disable-pip-version-check -r tools/judges/requirements.txt
        .venv/judges/bin/pip install --quiet --disable-pip-version-check --no-deps unifr-api-epuck==1.3.11
        echo "$wanted" > .venv/judges/installed
    fi
fi

python=.venv/judges/bin/python
if wants epuck2; then
    cargo build --quiet -p metal-cli
    judge "unifr-api-epuck 1.3.11 against metal serve epuck2" 60 $python tools/judges/epuck2.py "$target/debug/metal"
fi
if wants recordings; then
    cargo build --quiet -p metal-cli
    "$target/debug/metal" run tools/judges/recorded.toml --seeds 1 --out "$target/recorded" --force \
        --record "$target/recorded.mcap" > /dev/null
    judge "mcap-ros2-support and rosbags on a recording of ours" 60 \
        $python tools/judges/recordings.py "$target/recorded.mcap"
fi
if wants worlds; then
    # Its JavaScript engine for templates is large, so it is a package of its own.
    cargo build --quiet --manifest-path tools/judges/worlds/Cargo.toml --target-dir "$target/judges"
    judge "webots-proto on the world that we write" 60 "$target/judges/debug/worlds-judge"
fi
if wants enki; then
    cargo build --quiet -p metal-robots --example paths
    judge "Enki against our kinematics, contacts and infra-red ring" 120 \
        /usr/bin/python3 tools/judges/enki.py "$target/debug/examples/paths" "$target/enki.svg"
    # Same seeds, same figure, as long as it is the same Enki on the same machine.
    cmp --quiet "$target/enki.svg" docs/images/enki.svg || echo "  the figure in docs/images is another one: $target/enki.svg"
fi
if wants webots; then
    # A package of its own, so that nobody else has to build Webots' library.
    cargo build --quiet --manifest-path tools/judges/webots/Cargo.toml --target-dir "$target/judges"
    library=$(find "$target/judges" -path '*/out/webots/lib/controller' -type d | head -n 1)
    LD_LIBRARY_PATH="$library" judge "libController of Webots R2023b against metal serve webots" 60 \
        "$target/judges/debug/webots-judge"
fi
if wants ros; then
    cargo build --quiet -p metal-cli
    ours=(--quiet --manifest-path crates/metal-ros/Cargo.toml --target-dir "$target/ros")
    cargo build "${ours[@]}"
    cargo test "${ours[@]}" > /dev/null
    if [ -z "$run" ]; then
        run="$target/judges-run"
        [ -e "$run/run.json" ] || "$target/debug/metal" reproduce --quick --seeds 1 --out "$run" > /dev/null
    fi
    # A network of its own with nothing but a loopback device: DDS calls for partners by multicast.
    alone=(unshare -n)
    [ "$(id -u)" -eq 0 ] || alone=(unshare -rn)
    judge "Cyclone DDS against a ROS 2 node of ours" 120 "${alone[@]}" tools/judges/ros.sh \
        "$PWD/$python" "$target/debug/metal" "$target/ros/debug/metal-ros" "$run"
fi
echo "the judges agree"
