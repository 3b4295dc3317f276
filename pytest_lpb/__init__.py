"""pytest-lpb: benchmark local motion planners with pytest.

Importing this package loads nothing heavy: the public names below are imported on first use (PEP 562).
"""

import sys
from importlib import import_module
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

_EXPORTS = {
    "Infeasible": "pytest_lpb.errors",
    "KpiError": "pytest_lpb.errors",
    "LpbError": "pytest_lpb.errors",
    "ScenarioError": "pytest_lpb.errors",
    "Planner": "pytest_lpb.planner.base",
    "Preview": "pytest_lpb.problem.preview",
    "Problem": "pytest_lpb.problem.problem",
    "Trajectory": "pytest_lpb.trajectory",
    "kpi": "pytest_lpb.kpis.registry",
    "plot": "pytest_lpb.report.plots",
    "Run": "pytest_lpb.library.runs",
    "Scenario": "pytest_lpb.scenario.load",
    "evaluate": "pytest_lpb.library.evaluate",
    "load_planner": "pytest_lpb.library.planners",
    "register_engine": "pytest_lpb.problem.registration",
    "register_goal": "pytest_lpb.problem.registration",
    "register_robot": "pytest_lpb.problem.registration",
    "register_shape": "pytest_lpb.problem.registration",
    "register_urdf": "pytest_lpb.problem.registration",
    "load_run": "pytest_lpb.library.runs",
    "load_scenario": "pytest_lpb.scenario.load",
    "run_trial": "pytest_lpb.library.trial",
}

__all__ = [
    "Infeasible",
    "KpiError",
    "LpbError",
    "Planner",
    "Preview",
    "Problem",
    "Run",
    "Scenario",
    "ScenarioError",
    "Trajectory",
    "__version__",
    "evaluate",
    "kpi",
    "load_planner",
    "load_run",
    "load_scenario",
    "plot",
    "register_engine",
    "register_goal",
    "register_robot",
    "register_shape",
    "register_urdf",
    "run_trial",
]

if TYPE_CHECKING:
    from pytest_lpb.errors import Infeasible, KpiError, LpbError, ScenarioError
    from pytest_lpb.kpis.registry import kpi
    from pytest_lpb.library.evaluate import evaluate
    from pytest_lpb.library.planners import load_planner
    from pytest_lpb.library.runs import Run, load_run
    from pytest_lpb.library.trial import run_trial
    from pytest_lpb.planner.base import Planner
    from pytest_lpb.problem.preview import Preview
    from pytest_lpb.problem.problem import Problem
    from pytest_lpb.problem.registration import (
        register_engine,
        register_goal,
        register_robot,
        register_shape,
        register_urdf,
    )
    from pytest_lpb.report.plots import plot
    from pytest_lpb.scenario.load import Scenario, load_scenario
    from pytest_lpb.trajectory import Trajectory


def __getattr__(name: str) -> Any:
    if name not in _EXPORTS:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(_EXPORTS[name]), name)
    globals()[name] = value
    return value


if "gymnasium" in sys.modules:  # who uses gymnasium expects `import pytest_lpb` to register the environment
    import_module("pytest_lpb.environment")


def __dir__() -> list[str]:
    return sorted(__all__)
