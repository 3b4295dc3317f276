"""A worker that dies takes its report along; the controller writes the trial's row. Registered with xdist only."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any

import pytest

from pytest_lpb.errors import LpbError
from pytest_lpb.plugin.session import WORKER_CONTROLLER, WORKER_ROOT, WORKER_RUN, LpbSession, without_group
from pytest_lpb.scenario.draw import draw_problem
from pytest_lpb.trial.files import write_trial
from pytest_lpb.trial.outcome import WORKER_CRASH
from pytest_lpb.trial.specification import TrialSpecification
from pytest_lpb.trial.trial import failed_trial


class CrashPlugin:
    """Hooks that only xdist calls."""

    def __init__(self, session: LpbSession, tell: Callable[[str], None]) -> None:
        self._session = session
        self._tell = tell  # takes what goes wrong here: an exception would end the run

    @pytest.hookimpl(optionalhook=True)
    def pytest_configure_node(self, node: Any) -> None:
        """Tell a worker which run it belongs to."""
        node.workerinput[WORKER_RUN] = str(self._session.run)
        node.workerinput[WORKER_ROOT] = str(self._session.rootdir)
        node.workerinput[WORKER_CONTROLLER] = os.getpid()
        source = self._session.source
        # `latest` may lead elsewhere by the time that a worker looks.
        node.workerinput["lpb_resume"] = str(self._session.run)
        node.workerinput["lpb_problems"] = "" if source is None else str(source.path.parent)

    @pytest.hookimpl(optionalhook=True)
    def pytest_handlecrashitem(self, crashitem: str) -> None:
        """Write a row for the trial that its worker did not survive."""
        try:
            write_crash(self._session, crashitem)
        except LpbError as error:
            self._tell(f"the process that ran {crashitem} died, and this cannot be recorded: {error}")


def write_crash(session: LpbSession, node_id: str) -> None:
    """Write the zero-row file of a trial whose process died; items that are no trials are left alone.

    Raises LpbError when it cannot be written, or the scenario cannot be read any more.
    """
    trial = session.trial_of(node_id)
    if trial is None:
        return
    node_id = without_group(node_id)
    key, name, seed = trial
    planner = next(planner for planner in session.planners if planner.name == name)
    scenario = session.families([node_id])[key].scenario(seed)
    try:
        problem = draw_problem(scenario, seed, session.flags, key).to_dict()
    except LpbError:
        # It could not be drawn in the worker either; the row still says which trial was lost.
        problem = scenario.concrete | {"seed": seed, "trials": 1}
    specification = TrialSpecification(
        problem=problem,
        planner=planner,
        scenario=key,
        node_id=node_id,
        command=session.repeat_command(node_id, planner.name, seed),
        workers=session.workers,
    )
    message = "the process that ran the trial died; run it alone to see why"
    write_trial(session.run, failed_trial(specification, WORKER_CRASH, message))
