"""Calls sgc on saved designs and run folders."""

import os
import re
import subprocess
import tempfile
from pathlib import Path

SGC = os.environ.get("SGC", "sgc")


def call(*arguments):
    """What sgc writes to standard output; an error ends with what it said."""
    done = subprocess.run([SGC, *map(str, arguments)], capture_output=True, text=True)
    if done.returncode != 0:
        raise RuntimeError(f"sgc {' '.join(map(str, arguments))}: {done.stderr.strip()}")
    return done.stdout


def value(*arguments):
    """The value that `sgc eval` prints; not a number if the motion is not valid."""
    try:
        out = call("eval", *arguments)
    except RuntimeError as error:
        if "the motion is not valid" in str(error):
            return float("nan")
        raise
    return float(re.match(r"value (\S+)", out).group(1))


def score(design, motion):
    """The value of a motion (the text of a table) by the objective of a design."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "motion.csv"
        file.write_text(motion)
        return value(design, "--motion", file)


def designs(paths):
    """Designs and run folders, also those in a folder of run folders, with short names."""
    for path in map(Path, paths):
        if path.is_dir() and not (path / "best.design.json").exists():
            inside = [p for p in path.iterdir() if (p / "best.design.json").exists()]
            yield from ((p.name, p) for p in sorted(inside))
        else:
            yield path.name.removesuffix(".design.json"), path
