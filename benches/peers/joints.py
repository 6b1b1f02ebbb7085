"""How far apart MuJoCo and sgc are after half a second, for bodies whose joints bend, twist, slide, spin and hang.

    python benches/peers/joints.py FOLDER

The table has, for each design, its degrees of freedom beside those of its root, and the median over its elements of the
distance between the two, in mm: with MuJoCo's contacts at sgc's own step, and at a sixteenth of it, where they are stiffer.
"""

import statistics
import sys

import mujoco
import numpy as np

import in_mujoco
from program import call, designs

AFTER = 0.5
STEPS = (1 / 240, 1 / 3840)


def places(design):
    """Where sgc has the elements after that time: a row for each."""
    rows = in_mujoco.table(call("export", design, "--to", "motion"))
    times = np.array([line.split(",", 1)[0] for line in call("export", design, "--to", "motion").splitlines()[1:]], float)
    row = rows[np.argmin(abs(times - AFTER))]
    return row.reshape(-1, 7)[:, :3]


def distance(design, step, here):
    """The median distance of the elements in MuJoCo from where they are here, mm, and the degrees of freedom."""
    model, drive = in_mujoco.load(design, step)
    data = mujoco.MjData(model)
    for targets in drive[: round(AFTER / step)]:
        data.ctrl[:] = targets
        mujoco.mj_step(model, data)
    mujoco.mj_kinematics(model, data)
    there = in_mujoco.poses(model, data)[:, :3]
    return 1e3 * float(np.median(np.linalg.norm(there - here, axis=1))), model.nv - 6


def main():
    print("| design | degrees of freedom | 1/240 s | 1/3840 s |\n|---|---|---|---|")
    found = []
    for name, design in designs(sys.argv[1:]):
        here = places(design)
        rows = [distance(design, step, here) for step in STEPS]
        found.append([off for off, _ in rows])
        print(f"| {name} | {rows[0][1]} | {rows[0][0]:.1f} | {rows[1][0]:.1f} |")
    medians = [statistics.median(column) for column in zip(*found)]
    print(f"| median | | {medians[0]:.1f} | {medians[1]:.1f} |")


main()
