"""Options of the regression gate, from the command line or the ini file."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

import pytest

from pytest_lpb.errors import ConfigurationError
from pytest_lpb.kpis.registry import default_registry
from pytest_lpb.plugin.options import split_names
from pytest_lpb.run.baseline import PLANNER
from pytest_lpb.run.folder import LATEST, RunFolder
from pytest_lpb.run.gate_options import INCONCLUSIVE, CheckedGate, GateOptions


def gate_options(config: pytest.Config, ini_folder: Path) -> GateOptions | None:
    """The gate that is asked for; None without a baseline. Raises ConfigurationError for options that are wrong."""
    option = config.getoption("lpb_baseline")
    # Who names single trials wants to see them again, not to judge the planner.
    ini = "" if any("::" in argument for argument in config.args) else config.getini("lpb_baseline")
    baseline = ini if option is None else option
    margins = config.getoption("lpb_fail_on")
    fail_on = split_names(margins) if margins is not None else split_names(config.getini("lpb_fail_on")) or None
    inconclusive = config.getoption("lpb_inconclusive") or config.getini("lpb_inconclusive")
    if not baseline:
        # `--lpb-baseline=` turns off what the ini file asks for; nothing else may silently gate nothing.
        if margins is not None or (fail_on and option is None and not config.getini("lpb_baseline")):
            raise ConfigurationError(
                "--lpb-fail-on (or ini lpb_fail_on): nothing to compare with; say with "
                f"--lpb-baseline=RUN_OR_FILE, or {PLANNER}NAME"
            )
        return None
    here = config.invocation_params.dir
    if not baseline.startswith(PLANNER):
        path = (ini_folder if option is None else here) / baseline
        # `latest` leads to this run soon.
        path = RunFolder.open(path).path if path.name == LATEST else Path(os.path.normpath(path))
        baseline = str(path.relative_to(here) if path.is_relative_to(here) else path)
    return GateOptions(baseline, fail_on, inconclusive or INCONCLUSIVE[0], "--lpb-")


def restore_gate(config: pytest.Config, run: RunFolder) -> None:
    """Gate a run that is finished later as it was to be gated, unless the options say something else."""
    recorded = run.info().get("gate")
    if recorded and config.option.lpb_baseline is None:
        config.option.lpb_baseline = recorded["baseline"]
        config.option.lpb_fail_on = ",".join(recorded["fail_on"])
        config.option.lpb_inconclusive = recorded["inconclusive"]


def checked_gate(
    options: GateOptions | None, folder: Path, planners: Sequence[str], kpis: Sequence[str] | None
) -> CheckedGate | None:
    """The gate, checked against planners and KPIs of the run. Raises LpbError."""
    if options is None:
        return None
    return options.gate(folder, planners, default_registry.select(kpis))
