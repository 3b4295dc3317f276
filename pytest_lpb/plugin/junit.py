"""Outcome and KPIs of a trial as properties of its test case in pytest's own junit file.

Properties travel as plain text: what xdist cannot send (a NumPy scalar) would end the run.
"""

from __future__ import annotations

import math

import pytest

from pytest_lpb.kpis.registry import default_registry, evaluate_kpis
from pytest_lpb.plugin.session import session_of
from pytest_lpb.trajectory import Trajectory

PREFIX = "lpb_"
RECORDED = ("outcome", "success", "failed_criteria", "problem_hash", "attempt")


def add_properties(item: pytest.Item, trajectory: Trajectory) -> None:
    """Add a trial's outcome and KPIs to its item, once: as in the tables, the first attempt of a rerun trial counts."""
    if any(name.startswith(PREFIX) for name, _ in item.user_properties):
        return
    # Faults of KPIs are named at the end of the run, where all of them are evaluated for the tables.
    values, _ = evaluate_kpis(trajectory, default_registry.select(session_of(item.config).kpis))
    recorded = {name: _text(trajectory.metadata[name]) for name in RECORDED}
    recorded["timing_contended"] = _text(trajectory.timing_contended)
    known = {name: repr(value) for name, value in values.items() if not math.isnan(value)}
    item.user_properties.extend((PREFIX + name, text) for name, text in {**recorded, **known}.items())


def _text(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return "; ".join(map(str, value)) if isinstance(value, list | tuple) else str(value)
