"""A worker that dies: its trial has a row, the others are kept, the run goes on."""

from __future__ import annotations

import pytest

from .projects import DRAWN, Project, read_table, text_of

FATAL = """
import os
import numpy as np
import pytest
from pytest_lpb import Planner

class Fatal(Planner):
    name = "fatal"

    def setup(self, problem):
        self.seed = problem.seed

    def compute_action(self, observation):
        if self.seed == 1:
            os._exit(3)
        return np.zeros(2)

class Late(Fatal):
    name = "late"

    def compute_action(self, observation):
        return np.zeros(2)

    def close(self):
        with open("closed", "a") as file:
            first = file.tell() == 0
            file.write("x")
        if first:
            os._exit(3)

def pytest_collection_modifyitems(items):
    for item in items:
        item.add_marker(pytest.mark.xdist_group(item.parent.name))
"""


@pytest.fixture
def doomed(project: Project) -> Project:
    project.write("conftest.py", FATAL)
    project.scenario(content=DRAWN)
    return project


@pytest.mark.parametrize("mode", ["load", "loadgroup"])
def test_the_row_of_a_crash(doomed: Project, mode: str) -> None:
    result = doomed.run_workers("--dist", mode, "--lpb-trials=4", "scenarios", planners="fatal,pd")
    outcomes = result.parseoutcomes()
    # xdist's scopes hand a crashed item to further workers: it must not take all of them down.
    assert outcomes["passed"] == 7
    assert 1 <= outcomes["failed"] <= (1 if mode == "load" else 4)
    assert result.ret == 1
    rows = {(row["planner"], row["seed"]): row for row in doomed.rows()}
    assert len(rows) == 8
    crash = rows.pop(("fatal", "1"))
    assert (crash["outcome"], crash["success"], crash["steps"]) == ("worker_crash", "false", "0")
    assert crash["node_id"] == "scenarios/point/x.yaml::fatal::seed1"
    assert crash["trajectory_hash"] == ""
    assert crash["problem_hash"] == rows["pd", "1"]["problem_hash"]
    assert {row["outcome"] for row in rows.values()} == {"success"}
    run = doomed.runs()[-1]
    # The problem was written before the trial ran: it can be looked at.
    assert (run / "trials/point/x/fatal/seed1.yaml").is_file()
    (summary,) = [
        row for row in read_table(run / "summary.csv") if (row["planner"], row["scenario"]) == ("fatal", "all")
    ]
    assert (summary["trials"], summary["successes"]) == ("4", "3")
    assert "1 trial of fatal: worker_crash: the process that ran the trial died; run it alone" in text_of(result)


def test_a_process_that_dies_after_its_trials(doomed: Project) -> None:
    # The planner's `close` takes the process down once its trials are written: they are kept as they were.
    result = doomed.run_workers("--dist", "loadscope", "--lpb-trials=2", "scenarios", planners="late,pd")
    assert "INTERNALERROR" not in text_of(result)
    rows = doomed.rows()
    assert [(row["planner"], row["outcome"]) for row in rows] == [
        (planner, "success") for planner in ("late", "late", "pd", "pd")
    ]
