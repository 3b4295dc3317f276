"""The process that does a job: `python -m pytest_lpb.fairness.serve JOB ANSWERS PARENT`."""

from __future__ import annotations

import sys
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from threadpoolctl import threadpool_limits

from pytest_lpb.errors import LpbError
from pytest_lpb.fairness.canary import reactions
from pytest_lpb.fairness.job import RUN, Job, answer_line
from pytest_lpb.planner.configuration import PlannerConfiguration
from pytest_lpb.run.folder import RunFolder
from pytest_lpb.run.orphans import end_with_parent
from pytest_lpb.run.plan import TrialKey
from pytest_lpb.run.recorded_planners import recorded_planners
from pytest_lpb.run.reproduce import HASHES
from pytest_lpb.trial.files import read_trial, trial_path
from pytest_lpb.trial.holder import PlannerHolder
from pytest_lpb.trial.specification import TrialSpecification
from pytest_lpb.trial.trial import run_trial


def serve(job: Job, answers: Path) -> None:
    """Take up a job's trials one after the other; each answer is written at once. Raises LpbError."""
    names = dict.fromkeys(trial.planner for trial in job.trials)
    planners, _ = recorded_planners(RunFolder.open(job.run), names, trusted=True)  # its own run has just started them
    holders: dict[tuple[str, str], PlannerHolder] = {}
    with ExitStack() as stack, answers.open("a", encoding="utf-8") as file:
        stack.enter_context(threadpool_limits(limits=1))  # as in the run
        for key in job.trials:
            where = (key.scenario, key.planner)
            if where not in holders:
                # As in the run: one instance has all trials of a scenario.
                holders[where] = PlannerHolder(planners[key.planner])
                stack.callback(_close, holders[where])
            file.write(answer_line(key, _answer(job, key, planners[key.planner], holders[where])))
            file.flush()


def _close(holder: PlannerHolder) -> None:
    """Close a planner; what it raises the run has told already."""
    try:
        holder.close()
    except LpbError as error:
        print(error, file=sys.stderr)


def _answer(job: Job, key: TrialKey, configuration: PlannerConfiguration, holder: PlannerHolder) -> dict[str, Any]:
    problem = read_trial(trial_path(job.run, *key)).problem
    if job.task == RUN:
        specification = TrialSpecification(problem.to_dict(), configuration, key.scenario)
        metadata = run_trial(specification, holder).metadata
        return {name: metadata[name] for name in HASHES}
    return reactions(holder, configuration, problem)


def main() -> None:
    """Do the job that the command line names."""
    job_file, answers, parent = Path(sys.argv[1]), Path(sys.argv[2]), int(sys.argv[3])
    end_with_parent(parent)
    try:
        serve(Job.from_json(job_file.read_text(encoding="utf-8")), answers)
    except LpbError as error:
        sys.exit(str(error))


if __name__ == "__main__":
    main()
