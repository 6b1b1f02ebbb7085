"""How far the value of a gait is a matter of chance, by sgc's own solver and by MuJoCo.

    python spread.py DESIGN|RUN|FOLDER... [--times N]

Simulates each design several times by both, at steps of about 1/2000 s that differ a little. A gait
that stands at a bifurcation (a tumbling one, say) then takes other paths, and its values spread; two
methods agree about it if their values spread over the same range. It prints both lists, sorted.
"""

import argparse

import numpy as np

import in_mujoco
from program import designs, score, value


def main():
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("paths", nargs="+", metavar="DESIGN|RUN|FOLDER")
    parser.add_argument("--times", type=int, default=5, help="how often [5]")
    options = parser.parse_args()
    # Multiples of the rows of a motion, so that a row is an exact number of steps.
    rates = [2000 + in_mujoco.ROWS * (i - options.times // 2) for i in range(options.times)]
    for name, design in designs(options.paths):
        own = [value(design, "--step", repr(1 / rate)) for rate in rates]
        other = []
        for rate in rates:
            rows = in_mujoco.simulate(*in_mujoco.load(design, 1 / rate))
            other.append(float("nan") if rows is None else score(design, in_mujoco.motion(rows)))
        text = ["  ".join(f"{v:8.2f}" for v in sorted(values)) for values in (own, other)]
        gap = abs(np.mean(own) - np.mean(other))
        # Standard error of the difference of two means.
        noise = np.sqrt((np.var(own, ddof=1) + np.var(other, ddof=1)) / len(own))
        print(f"{name:<14} sgc {text[0]}   MuJoCo {text[1]}   apart {gap:.2f} +- {noise:.2f}", flush=True)


if __name__ == "__main__":
    main()
