#!/usr/bin/env python3
"""How much of a robot's pose its looks at one sensor tell, whatever is made of them.

    cargo run --release -p metal-lab --example diary -- experiments/attention.toml 31/0 RN runs=1000 log=rn.csv
    python3 tools/what_looks_tell.py rn.csv RN

The log is of a driver that looks at that sensor in every step. A forest of trees,
fitted to half of the episodes, foretells offset and heading in the lane before each move from the last looks at every k-th step and all
moves since the first of them; printed is the share of the variance that it explains in the other half. It needs numpy,
pandas and scikit-learn.
"""

import sys

import numpy as np
import pandas as pd
from sklearn.ensemble import ExtraTreesRegressor

#: What is to be foretold: measures of the step before, so it is where the robot stands when it decides.
POSE = ("lane_offset_m", "heading_error_rad")
#: Steps without which no row has a past long enough for the slowest rhythm and two looks.
LONGEST = 8


def rows(episodes, sensor, every, looks, age):
    """Inputs and poses where the last look is `age` steps old and `looks` of them, `every` steps apart, are remembered."""
    found, poses = [], []
    for steps in episodes:
        readings, actions, pose = steps[sensor].to_numpy(), steps["action"].to_numpy(int), steps[list(POSE)].to_numpy()
        moves = np.eye(actions.max(initial=4) + 1)[actions]
        for now in range(LONGEST + 1, len(steps)):
            seen = [now - age - every * i for i in range(looks)]
            # A measure belongs to the step that led to it: the pose at `now` is that after the move of the step before.
            found.append(np.concatenate([*(readings[i] for i in seen), moves[seen[-1] : now].ravel()]))
            poses.append(pose[now - 1])
    return np.array(found), np.array(poses)


def explained(inputs, poses, held_out):
    """Share of the variance of each number of the pose in held-out rows."""
    forest = ExtraTreesRegressor(100, min_samples_leaf=5, random_state=0, n_jobs=-1).fit(inputs[~held_out], poses[~held_out])
    errors = ((forest.predict(inputs[held_out]) - poses[held_out]) ** 2).mean(axis=0)
    return 1.0 - errors / poses[held_out].var(axis=0)


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    try:
        log = pd.read_csv(sys.argv[1])
    except (OSError, ValueError) as error:
        sys.exit(f"{sys.argv[1]}: {error}")
    sensor = [name for name in log.columns if name.startswith(f"{sys.argv[2]}.")]
    if not sensor:
        sys.exit(f"{sys.argv[1]}: no readings of {sys.argv[2]}")
    if log[sensor].isna().to_numpy().any():
        sys.exit(f"{sys.argv[1]}: {sys.argv[2]} was not read in every step")
    episodes = [steps for _, steps in log.groupby("episode")]
    print("| looks at every | remembered | age of the last | offset | heading |\n|---|---|---|---|---|")
    for every, looks in ((1, 1), (1, 2), (1, 4), (2, 1), (2, 2), (3, 1), (3, 2), (4, 2)):
        for age in range(every):
            tables = [rows([steps], sensor, every, looks, age) for steps in episodes]
            # Whole episodes are held out: steps of one are alike.
            held_out = np.concatenate([np.full(len(poses), i % 2 == 1) for i, (_, poses) in enumerate(tables)])
            inputs, poses = (np.concatenate(parts) for parts in zip(*tables))
            offset, heading = explained(inputs, poses, held_out)
            print(f"| {every} | {looks} | {age} | {offset:.2f} | {heading:.2f} |", flush=True)


if __name__ == "__main__":
    main()
