"""Starts the process that does a job."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

from pytest_lpb.fairness.job import Answers, Job, read_answers
from pytest_lpb.run.plan import TrialKey

SERVER = "pytest_lpb.fairness.serve"
SHOWN_LINES = 3


def have_done(job: Job) -> Answers:
    """Have a new process do a job, and wait for it. Where a trial ends it, another one goes on after that trial."""
    by_trial: dict[TrialKey, dict[str, Any]] = {}
    missing: dict[TrialKey, str] = {}
    left = list(job.trials)
    while left:
        answers, said = _answers(replace(job, trials=left))
        by_trial |= answers
        left = [key for key in left if key not in answers]
        if left:
            missing[left.pop(0)] = said
    return Answers(by_trial, missing)


def _answers(job: Job) -> tuple[dict[TrialKey, dict[str, Any]], str]:
    """What one process answers, and the end of what it said."""
    with tempfile.TemporaryDirectory(prefix="lpb-fairness-") as work:
        job_file, answers = Path(work) / "job.json", Path(work) / "answers.jsonl"
        job_file.write_text(job.to_json(), encoding="utf-8")
        command = [sys.executable, "-m", SERVER, str(job_file), str(answers)]
        # Planners print what they like, in any encoding.
        done = subprocess.run(
            command, stdin=subprocess.DEVNULL, capture_output=True, text=True, errors="replace", check=False
        )
        lines = answers.read_text(encoding="utf-8").splitlines(keepends=True) if answers.is_file() else []
    said = " / ".join(done.stderr.strip().splitlines()[-SHOWN_LINES:])
    return read_answers(lines), said or f"the process ended with {done.returncode}"
