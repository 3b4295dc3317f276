"""What a KPI declares about itself, and the checks on it."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Literal, SupportsFloat, get_args

from pytest_lpb.errors import KpiError
from pytest_lpb.kpis.units import same_unit, unit_of_name
from pytest_lpb.names import is_name, listed
from pytest_lpb.trajectory import Trajectory

Direction = Literal["lower", "higher", "none"]
Over = Literal["solved", "all"]
KpiFunction = Callable[[Trajectory], SupportsFloat]
Contention = Callable[[Trajectory], bool]

# Other columns of trials.csv, and keys of a scenario's `success`: a KPI could not be told from them.
RESERVED_NAMES = frozenset(
    (
        *("node_id", "scenario", "planner", "seed", "outcome", "success", "failed_criteria", "steps"),
        *("problem_hash", "trajectory_hash", "wall_s", "attempt", "timing_contended", "duration_s"),
        "contended_kpis",
        *("control", "message", "command", "hold_time", "rate"),
    )
)

# Spreadsheets read cells that begin with a sign as formulas, so a column begins with a letter.
_BEGINS_WITH_LETTER = re.compile(r"[A-Za-z]")


@dataclass(frozen=True)
class Kpi:
    """One KPI: what it measures, in which unit, and how tables treat it."""

    name: str  # column of trials.csv, its unit as suffix
    unit: str  # "1" when dimensionless
    direction: Direction  # which way is better; none: neither
    over: Over  # trials that tables compare: those solved, or all
    group: str  # heading in reports
    function: KpiFunction
    module: str  # where lpb-report finds it again
    timing: bool = False  # depends on the wall clock: never equal in two runs
    restricted_to_duration: bool = False  # where it is NaN, means count the scenario's duration [s]
    contention: Contention | None = None  # whether other work disturbed it; None: as `timing_contended` says

    def __post_init__(self) -> None:
        where = f"KPI {self.name!r} ({self.place})"
        if not is_name(self.name) or not _BEGINS_WITH_LETTER.match(self.name):
            raise KpiError(f"{where}: a name begins with a letter and has letters, digits and _ . - only")
        if self.name in RESERVED_NAMES:
            raise KpiError(f"{where}: the name is taken by a column of trials.csv or a key of `success`")
        if not self.unit or not self.unit.isprintable():
            raise KpiError(f"{where}: unit is {self.unit!r}; allowed is one such as 'm', or '1' for a plain number")
        suffix = unit_of_name(self.name)
        if suffix is not None and not same_unit(suffix, self.unit):
            raise KpiError(f"{where}: unit is {self.unit!r}, but the name says {suffix!r}")
        for key, found, allowed in (("direction", self.direction, Direction), ("over", self.over, Over)):
            if found not in get_args(allowed):
                raise KpiError(f"{where}: {key} is {found!r}; allowed: {listed(get_args(allowed))}")

    def __call__(self, trajectory: Trajectory) -> SupportsFloat:
        """The KPI's value for one trial, unchecked; `evaluate_kpis` checks it."""
        return self.function(trajectory)

    def is_contended(self, trajectory: Trajectory) -> bool:
        """Whether other work on the same cores may have disturbed the value; never for one that is no timing."""
        if not self.timing:
            return False
        return trajectory.timing_contended if self.contention is None else self.contention(trajectory)

    @property
    def place(self) -> str:
        """Where the function is defined, `file:line`; for a callable object, its class."""
        function = innermost(self.function)
        code = getattr(function, "__code__", None)
        if code is None:
            return f"{function.__module__}.{function.__qualname__}"
        return f"{Path(code.co_filename).resolve()}:{code.co_firstlineno}"


def innermost(function: Any) -> Any:
    """The function inside `functools.partial` objects; for another callable object, its class."""
    while isinstance(function, partial):
        function = function.func
    return function if hasattr(function, "__code__") else type(function)
