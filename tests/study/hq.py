"""A study on HyperQueue's local cluster: a worker process is killed at random, and what is left is submitted again.

    python tests/study/hq.py STUDY.toml FOLDER [KILLS]

SGC is the program (default: sgc). It needs the package `hyperqueue`, which has the engine and no `hq` program: so the tasks
are started as the script of `sgc study submit --to hq` would start them. The results must be those of the study done here, bit for bit.
"""

import os
import random
import re
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

from hyperqueue import Job, LocalCluster
from hyperqueue.cluster import WorkerConfig

SGC = os.environ.get("SGC", "sgc")
RUNS_PER_TASK = 2


def sgc(*arguments):
    """What the program says on standard output."""
    return subprocess.run([SGC, "study", *map(str, arguments)], check=True, capture_output=True, text=True).stdout


def workers(folder):
    """The processes that do runs of a study."""
    found = subprocess.run(["pgrep", "-f", f"study work .*{folder}"], capture_output=True, text=True).stdout.split()
    names = {pid: Path(f"/proc/{pid}/comm") for pid in found}
    return [int(pid) for pid, name in names.items() if name.exists() and name.read_text().startswith("sgc")]


def kill(folder, kills, over):
    """Kills workers at random as long as the job goes on, and counts down the list `kills`."""
    while kills and not over.is_set():
        time.sleep(0.5)
        found = workers(folder)
        if found:
            try:
                os.kill(random.choice(found), random.choice([signal.SIGKILL, signal.SIGTERM]))
            except ProcessLookupError:
                continue
            kills.pop()


def submit(cluster, folder):
    """Has the cluster do what is not complete; false where nothing is left."""
    text = sgc("submit", folder, "--to", "hq", "--runs-per-task", RUNS_PER_TASK)
    if not text:
        return False
    tasks = int(re.search(r"--array=0-(\d+)", text).group(1)) + 1
    script = max((folder / "submissions").glob("*/hq.sh"), key=lambda path: int(path.parent.name))
    # A task that was killed does not end the others.
    job = Job(max_fails=tasks)
    for task in range(tasks):
        job.program(["bash", str(script)], env=os.environ | {"HQ_TASK_ID": str(task)}, cwd=folder)
    client = cluster.client()
    submitted = client.submit(job)
    client.wait_for_jobs([submitted], raise_on_error=False)
    return True


def results(folder):
    """What the runs left that is the same each time."""
    names = ["best.design.json", "evals.csv", "result.json"]
    return {path.relative_to(folder): path.read_bytes() for name in names for path in folder.glob(f"runs/*/*/{name}")}


def main():
    study, folder = Path(sys.argv[1]), Path(sys.argv[2]).absolute()
    kills = [None] * (int(sys.argv[3]) if len(sys.argv) > 3 else 4)
    here, there = folder / "here", folder / "there"
    sgc(study, "--out", here, "--quiet")
    sgc("submit", study, "--out", there, "--to", "hq")
    with LocalCluster() as cluster:
        cluster.start_worker(WorkerConfig(cores=2))
        rounds = 0
        while rounds < 40:
            over = threading.Event()
            killer = threading.Thread(target=kill, args=(there, kills, over))
            killer.start()
            left = submit(cluster, there)
            over.set()
            killer.join()
            if not left:
                break
            rounds += 1
    print(sgc("status", there), end="")
    assert results(here) == results(there), "other results than here"
    print(f"the same bits after {rounds} submissions")


main()
