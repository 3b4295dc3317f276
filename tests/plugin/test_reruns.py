"""`--reruns` of pytest-rerunfailures: the first attempt of a trial counts."""

from __future__ import annotations

import pytest

from .projects import UNSOLVED, Project, attempt_of, text_of

# Solves the problem from its second trial in the same process on.
MOODY = """
import numpy as np
from pytest_lpb import Planner

class Moody(Planner):
    name = "moody"
    trials = 0

    def setup(self, problem):
        type(self).trials += 1

    def compute_action(self, observation):
        return np.full(2, 0.0 if self.trials > 1 else 1.0)
"""
RESTING = UNSOLVED.replace("target: [3.0, 0.0], tolerance: 0.1", "target: [0.0, 0.0], tolerance: 0.01")


def test_one_row_of_the_first_attempt(project: Project) -> None:
    project.write("conftest.py", MOODY)
    project.scenario(content=RESTING)
    result = project.run("--reruns", "2", "scenarios", planners="moody")
    assert "1 passed, 1 rerun" in text_of(result)
    row = project.row()
    assert (row["success"], row["attempt"]) == ("false", "1")
    assert attempt_of(project.runs()[-1] / "trials/point/x/moody/seed0.parquet") == 1
    # The table says what is in the data, not how the rerun ended.
    result.stdout.re_match_lines([r"moody +0/1 +1 +0 %"])


@pytest.mark.parametrize("workers", [0, 2])
def test_reruns_that_fail(project: Project, workers: int) -> None:
    project.scenario(content=UNSOLVED)
    arguments = ("--reruns", "2", "--lpb-trials=2", "scenarios")
    result = project.run_workers(*arguments) if workers else project.run(*arguments)
    assert result.ret == 1
    assert "2 failed, 4 rerun" in text_of(result)
    assert [row["attempt"] for row in project.rows()] == ["1", "1"]
