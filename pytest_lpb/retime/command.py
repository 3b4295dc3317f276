"""Times the recorded calls of a run again: pytest with pytest-benchmark's fixture in a process of its own."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from importlib.resources import files
from pathlib import Path

import pandas as pd

from pytest_lpb.documents.atomic import replace_file
from pytest_lpb.errors import LpbError
from pytest_lpb.retime.job import Job
from pytest_lpb.retime.result import Retimed, read_retimed
from pytest_lpb.run.folder import RunFolder
from pytest_lpb.run.recorded_planners import recorded_planners

PLUGIN = "pytest_lpb.plugin.retiming"
CALLS = "calls.py"  # the file with the test
# A user's settings are for other runs: workers have no timing, and plugins may shuffle, repeat or trace tests.
PYTESTS, OWN = "PYTEST_", "PYTEST_LPB_"
ALONE = {"PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}
SHOWN_LINES = 15


def retime(run: RunFolder, trials: pd.DataFrame, passes: int, target: Path, *, trusted: bool = False) -> Retimed:
    """Time the calls of trials again and write what pytest-benchmark measured.

    Args:
        run: the run folder.
        trials: rows of its trials.csv.
        passes: how often each call is made and timed.
        target: JSON file to write, in pytest-benchmark's format.
        trusted: whether the run may name programs, interpreters and hosts that are started.

    Raises:
        LpbError: a planner cannot be loaded, or nothing could be timed.
    """
    kept = trials[trials["steps"] > 1]
    keys = zip(kept["scenario"], kept["planner"], kept["seed"], strict=True)
    job = Job(run.path, passes, [(str(scenario), str(planner), int(seed)) for scenario, planner, seed in keys], trusted)
    if not job.trials:
        raise LpbError("--retime: no trial of the selection has two steps, so there are no calls to time")
    # In this process first: what cannot be loaded is told at once, and in one line.
    recorded_planners(run, dict.fromkeys(planner for _, planner in job.keys), trusted=trusted)
    with tempfile.TemporaryDirectory(prefix="lpb-retime-") as work:
        measured = Path(work) / "measured.json"
        said = _run_pytest(job, Path(work) / "job.json", measured)
        retimed = read_retimed(measured)
        if retimed is None or not retimed.rows:
            reasons = "\n".join(retimed.warnings if retimed else [said])
            raise LpbError(f"--retime: nothing could be timed:\n{reasons}")
        replace_file(target, measured.read_bytes())
    return retimed


def _run_pytest(job: Job, job_file: Path, measured: Path) -> str:
    """Have pytest do a job, and write what it measured, if anything; the end of what it said."""
    job_file.write_text(job.to_json(), encoding="utf-8")
    command = [
        # Not to import what lies in the current folder: it may be the run folder.
        *(sys.executable, "-P", "-m", "pytest", "-q", "-rs", "-c", os.devnull, f"--rootdir={job.run}", "-n", "0"),
        *("-p", "xdist.plugin", "-p", "pytest_benchmark.plugin", "-p", PLUGIN, "-p", "no:cacheprovider"),
        *(f"--lpb-job={job_file}", f"--benchmark-json={measured}", "--benchmark-quiet"),
        str(files(PLUGIN) / CALLS),
    ]
    settings = {key for key in os.environ if key.startswith(PYTESTS) and not key.startswith(OWN)}
    environment = {key: value for key, value in os.environ.items() if key not in settings} | ALONE
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    if measured.is_file() and not measured.stat().st_size:
        measured.unlink()  # pytest-benchmark opens it before it knows whether it has anything to write
    lines = (done.stdout + done.stderr).strip().splitlines()[-SHOWN_LINES:]
    return "\n".join([*lines, f"pytest ended with {done.returncode}"])
