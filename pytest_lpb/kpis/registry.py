"""Registry of KPIs: the decorator `kpi`, and the order in which KPIs appear in tables.

A KPI is a function of one `Trajectory` that gives one number: NaN, never a sentinel, where it does not apply.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from importlib import import_module
from typing import Any, TypeVar

from pytest_lpb.errors import KpiError
from pytest_lpb.kpis.definition import Contention, Direction, Kpi, Over, innermost
from pytest_lpb.kpis.evaluate import evaluate_kpis
from pytest_lpb.names import listed, suggestion
from pytest_lpb.trajectory import Trajectory

__all__ = ["Kpi", "Registry", "default_registry", "evaluate_kpis", "kpi", "load_builtin"]

F = TypeVar("F", bound=Callable[[Trajectory], Any])

GROUPS = ("goal", "path", "safety", "smoothness", "solver", "timing")
BUILTIN_MODULES = tuple(f"pytest_lpb.kpis.{group}" for group in GROUPS)


class Registry:
    """KPIs by name. All but tests use `default_registry`."""

    def __init__(self) -> None:
        self._kpis: dict[str, Kpi] = {}

    def __len__(self) -> int:
        return len(self._kpis)

    def __contains__(self, name: object) -> bool:
        return name in self._kpis

    def __iter__(self) -> Iterator[Kpi]:
        """All KPIs: the built-in ones in the order of their definition, then users' as registered."""
        return iter(sorted(self._kpis.values(), key=_module_rank))

    def kpi(
        self,
        name: str,
        unit: str,
        direction: Direction,
        over: Over,
        *,
        group: str = "user",
        timing: bool = False,
        restricted_to_duration: bool = False,
        contention: Contention | None = None,
    ) -> Callable[[F], F]:
        """Register a function of a `Trajectory` as a KPI: it returns a number, NaN where it does not apply.

        Args:
            name: column of trials.csv; ends with its unit, as in `elbow_height_min_m`.
            unit: as shown in tables, "1" when dimensionless; must agree with the name's suffix if it has one.
            direction: "lower" or "higher" is better; "none": neither.
            over: "solved": planners are compared on problems both solved; "all": on all problems.
            group: heading in reports.
            timing: whether it depends on the wall clock; such KPIs never gate while timing is contended.
            restricted_to_duration: whether means count the scenario's duration [s] where the KPI is NaN.
            contention: of a timing KPI: function of a `Trajectory` that says whether other work on the same cores
                disturbed its value; by default that is so where the trial's `timing_contended` is true.

        Raises:
            KpiError: a name, unit, direction or over that is not allowed, or a name that is taken.
        """

        def register(function: F) -> F:
            if not callable(function):
                raise KpiError(f"KPI {name!r}: {function!r} is not a function of a trajectory")
            module = innermost(function).__module__
            restricted = restricted_to_duration
            self.add(Kpi(name, unit, direction, over, group, function, module, timing, restricted, contention))
            return function

        return register

    def add(self, entry: Kpi) -> None:
        """Register a KPI; once more from the same place (a module imported again) replaces it.

        Raises:
            KpiError: the name is taken by a function from another place.
        """
        known = self._kpis.get(entry.name)
        if known is not None and known.place != entry.place:
            raise KpiError(f"KPI {entry.name!r} is defined twice: at {known.place} and at {entry.place}; rename one")
        self._kpis[entry.name] = entry

    def select(self, names: Iterable[str] | None = None) -> list[Kpi]:
        """KPIs of these names (None: all), each once, in the registry's order.

        Raises:
            KpiError: names that are not registered; each is listed with the nearest registered ones.
        """
        if names is None:
            return list(self)
        wanted = set(names)
        unknown = sorted(wanted - self._kpis.keys())
        if unknown:
            faults = [f"unknown KPI {name!r}{suggestion(name, self._kpis)}" for name in unknown]
            raise KpiError("\n".join([*faults, f"KPIs: {listed(self._kpis)}"]))
        return [entry for entry in self if entry.name in wanted]

    @contextmanager
    def preserved(self) -> Iterator[Registry]:
        """Undo on leaving whatever is registered inside: one pytest session's KPIs do not reach the next."""
        before = dict(self._kpis)
        try:
            yield self
        finally:
            self._kpis = before


default_registry = Registry()
kpi = default_registry.kpi


def load_builtin() -> Registry:
    """Import the built-in KPIs; returns the registry that holds them. Raises KpiError: a name is taken."""
    for module in BUILTIN_MODULES:
        import_module(module)
    return default_registry


def _module_rank(entry: Kpi) -> int:
    return BUILTIN_MODULES.index(entry.module) if entry.module in BUILTIN_MODULES else len(BUILTIN_MODULES)
