"""How far sgc's own solver agrees with MuJoCo and with itself at finer steps.

    python agreement.py DESIGN|RUN|FOLDER... [--solref TIME DAMPING] [--csv FILE]

Every design is simulated by sgc at the step of its search, at a half and a quarter of it and
at 1/1920 s, by rapier, and by MuJoCo at 1000 and 2000 Hz with contacts as stiff as these steps
allow, and at 1000 Hz with MuJoCo's default contacts (soft), or those that --solref says. As
MuJoCo's contacts lift off the ground while they slide (sliding.py shows it), `coulomb` is a
third method: MuJoCo's bodies and shapes with Coulomb's law itself (coulomb.py), at 1000 Hz; `hull` is the same
where points between others carry nothing. All motions are scored by the design's own objective.

  early  the greatest distance in mm between where sgc at 1/1920 s and MuJoCo at 2000 Hz have an
         element in the first 0.5 s, before chance has had its say
  law    the same between sgc at 1/1920 s and Coulomb's law at 2000 Hz
  step   the same between sgc at the step of its search and at 1/1920 s
  same   the time in s until which the core is nowhere 5 mm from where sgc at 1/1920 s has it

The environment variable SGC names the program (default: sgc). Designs have one task.
"""

import argparse
import csv
import json
import sys

import mujoco
import numpy as np

import coulomb
import in_mujoco
from program import call, designs, score, value

REFERENCE = 1 / 1920


def ranks(values):
    """Ranks from zero; equal values share theirs."""
    values = np.asarray(values)
    return np.array([(values < v).sum() + ((values == v).sum() - 1) / 2 for v in values])


def spearman(a, b):
    """The rank correlation of two rows of values."""
    known = np.isfinite(a) & np.isfinite(b)
    if known.sum() < 3:
        return float("nan")
    return float(np.corrcoef(ranks(np.asarray(a)[known]), ranks(np.asarray(b)[known]))[0, 1])


def close(a, b, share, least=0.1):
    """Whether two values differ by less than a share of the first, or by less than it matters."""
    return abs(a - b) <= max(share * abs(a), least)


def own_motion(design, step):
    """What sgc's own solver makes of a design: its value, and the time and places of each row."""
    text = call("export", design, "--to", "motion", "--step", repr(step), "--solver", "articulated")
    rows = in_mujoco.table(text)
    times = np.array([float(line.split(",", 1)[0]) for line in text.splitlines()[1:]])
    return score(design, text), (times, rows.reshape(len(rows), -1, 7)[:, :, :3])


def distance(one, other):
    """How far every element is from where another motion has it, at the times that both have."""
    (times, a), (others, b) = one, other
    both = [(i, j) for i, t in enumerate(times) for j in [np.abs(others - t).argmin()] if abs(others[j] - t) < 1e-6]
    i, j = np.array(both).T
    return times[i], np.linalg.norm(a[i] - b[j], axis=2)


def early(times, apart):
    """The greatest distance of any element at the first five tenths of a second, mm."""
    tenths = np.abs(times * 10 - np.round(times * 10)) < 1e-6
    return 1000 * float(apart[tenths & (times < 0.55)].max())


def rapier(design):
    """What rapier said when the design was saved; simulated again where that is not there."""
    file = design / "best.design.json" if design.is_dir() else design
    for check in json.loads(file.read_text())["tasks"][0]["checks"]:
        if check["name"] == "rapier":
            return float("nan") if check["value"] is None else check["value"]
    return value(design, "--solver", "rapier")


def measure(name, design, soft):
    """One row of the table."""
    model, _ = in_mujoco.load(design, REFERENCE)
    step = mujoco.MjModel.from_xml_string(call("export", design, "--to", "mjcf")).opt.timestep
    row = {"design": name, "hinges": model.nu}
    row["sgc"], coarse = own_motion(design, step)
    for column, at in (("half", step / 2), ("quarter", step / 4)):
        row[column] = value(design, "--step", repr(at))
    row["1/1920"], fine = own_motion(design, REFERENCE)
    row["rapier"] = rapier(design)
    for column, rate, solref in (("mj1000", 1000, None), ("mj2000", 2000, None), ("soft", 1000, soft)):
        model, drive = in_mujoco.load(design, 1 / rate, solref)
        rows = in_mujoco.simulate(model, drive)
        row[column] = float("nan") if rows is None else score(design, in_mujoco.motion(rows))
        if column == "mj2000":
            row["early"], row["step"], row["same"] = float("nan"), early(*distance(fine, coarse)), 0.0
            if rows is not None:
                times, apart = distance(fine, (np.arange(len(rows)) / in_mujoco.ROWS, rows[:, :, :3]))
                row["early"] = early(times, apart)
                late = times[apart[:, 0] > 0.005]
                row["same"] = float(late[0]) if len(late) else float("inf")
    model, drive = in_mujoco.load(design, 1 / 2000)
    rows = coulomb.simulate(model, drive[:1000])
    row["law"] = early(*distance(fine, (np.arange(len(rows)) / in_mujoco.ROWS, rows[:, :, :3])))
    for column, hull in (("coulomb", False), ("hull", True)):
        model, drive = in_mujoco.load(design, 1 / 1000)
        rows = coulomb.simulate(model, drive, coulomb.Stepper(model, hull=hull))
        row[column] = score(design, in_mujoco.motion(rows))
    row["ratio"] = row["mj1000"] / row["sgc"] if row["sgc"] else float("nan")
    row["steady"] = close(row["sgc"], row["half"], 0.05, 0) and close(row["sgc"], row["quarter"], 0.05, 0)
    row["mujoco"] = close(row["sgc"], row["mj1000"], 0.1) or close(row["sgc"], row["mj2000"], 0.1)
    row["exact"], row["outer"] = (close(row["sgc"], row[column], 0.1) for column in ("coulomb", "hull"))
    return row


def show(row):
    """A row as text."""
    cells = []
    for key, cell in row.items():
        if isinstance(cell, bool):
            cell = "yes" if cell else "no"
        elif isinstance(cell, float):
            cell = f"{cell:.2f}"
        cells.append(f"{cell:>{max(8, len(key))}}" if key != "design" else f"{cell:<14}")
    return " ".join(cells)


def summary(rows):
    """What the table comes to."""
    of = lambda key: np.array([row[key] for row in rows], dtype=float)
    steady = [row for row in rows if row["steady"]]
    print(f"\nvalues that change by less than 5 % when the step is halved twice: {len(steady)} of {len(rows)}")
    others = [row for row in rows if not row["steady"]]
    for what, key in (
        ("MuJoCo at 1000 or 2000 Hz", "mujoco"),
        ("Coulomb's law", "exact"),
        ("Coulomb's law at outer points", "outer"),
    ):
        counts = [f"{sum(row[key] for row in some)} of {len(some)}" for some in (steady, others)]
        print(f"of these, within 10 % (or 0.1) of {what}: {counts[0]}; of the others: {counts[1]}")
    itself = [sum(close(row["mj1000"], row["mj2000"], 0.1) for row in some) for some in (steady, others)]
    print(
        f"MuJoCo within 10 % of itself at 1000 and 2000 Hz: {itself[0]} of {len(steady)}; {itself[1]} of {len(others)}"
    )
    early = [f"{np.nanmedian(of(key)):.2f} ({np.nanmax(of(key)):.2f})" for key in ("early", "law", "step")]
    print(f"early differences in mm, median (most): from MuJoCo {early[0]}; from Coulomb's law {early[1]}; ", end="")
    print(f"of the search step {early[2]}")
    print("rank correlations (Spearman):")
    for what, a, b in (
        ("search step with 1/1920 s", "sgc", "1/1920"),
        ("quarter of it with 1/1920 s (the ceiling)", "quarter", "1/1920"),
        ("search step with MuJoCo at 1000 Hz", "sgc", "mj1000"),
        ("1/1920 s with MuJoCo at 2000 Hz", "1/1920", "mj2000"),
        ("search step with Coulomb's law", "sgc", "coulomb"),
        ("MuJoCo at 1000 Hz with Coulomb's law", "mj1000", "coulomb"),
        ("MuJoCo at 1000 Hz with 2000 Hz", "mj1000", "mj2000"),
        ("soft with stiff contacts of MuJoCo at 1000 Hz", "soft", "mj1000"),
        ("rapier with MuJoCo at 2000 Hz", "rapier", "mj2000"),
    ):
        print(f"  {spearman(of(a), of(b)):6.3f}  {what}")


def main():
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("paths", nargs="+", metavar="DESIGN|RUN|FOLDER")
    parser.add_argument(
        "--solref", nargs=2, type=float, metavar=("TIME", "DAMPING"), default=(0.02, 1), help="soft contacts [0.02 1]"
    )
    parser.add_argument("--csv", metavar="FILE", help="write the table there, too")
    options = parser.parse_args()
    rows = []
    for name, design in designs(options.paths):
        row = measure(name, design, options.solref)
        if not rows:
            print(" ".join(f"{key:>{max(8, len(key))}}" if key != "design" else f"{key:<14}" for key in row))
        rows.append(row)
        print(show(row), flush=True)
    if not rows:
        sys.exit("no designs there")
    summary(rows)
    if options.csv:
        with open(options.csv, "w", newline="") as file:
            writer = csv.DictWriter(file, rows[0])
            writer.writeheader()
            writer.writerows(rows)


if __name__ == "__main__":
    main()
