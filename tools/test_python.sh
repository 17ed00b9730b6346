#!/usr/bin/env bash
# The Python package: builds it into an environment of its own, runs its tests and the programs of its guide.
# `--peers` installs Stable-Baselines3 first, so that its checks run, too (it brings torch, some gigabytes);
# `--cluster` runs the sweep on a local Ray cluster of two nodes instead, one of which is killed.
set -euo pipefail
cd "$(dirname "$0")/.."

environment=${METAL_PYTHON_ENV:-.venv-python}
[ -x "$environment/bin/python" ] || python3 -m venv "$environment"
export VIRTUAL_ENV="$PWD/$environment" PATH="$PWD/$environment/bin:$PATH"
case "$environment" in /*) export VIRTUAL_ENV="$environment" PATH="$environment/bin:$PATH" ;; esac

wanted=$(cat python/requirements-test.txt)
if [ "$(cat "$VIRTUAL_ENV/installed" 2> /dev/null)" != "$wanted" ]; then
    python -m pip install --quiet --disable-pip-version-check -r python/requirements-test.txt
    echo "$wanted" > "$VIRTUAL_ENV/installed"
fi
tests="not cluster"
case "${1:-}" in
    --peers) python -m pip install --quiet --disable-pip-version-check 'stable-baselines3>=2.6' 'sb3-contrib>=2.6' ;;
    --cluster)
        python -m pip install --quiet --disable-pip-version-check 'ray>=2.40'
        tests=cluster
        ;;
esac

# The profile of the other tests, so that nothing is built twice.
maturin develop --quiet --profile dev
python -m pytest -q -m "$tests"
