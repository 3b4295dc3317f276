"""Plots of raw data: the decorator `plot`, and files in PNG and PDF.

A plot is a function that draws on matplotlib axes: of one trial, of a scenario's trials, or of a run's.
Importing this module does not import matplotlib.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeVar, get_args

from pytest_lpb.errors import ConfigurationError
from pytest_lpb.names import is_name, listed, suggestion

if TYPE_CHECKING:
    from pytest_lpb.report.data import ReportData

Scope = Literal["trial", "scenario", "run"]
# What a built-in plot of tables draws: parts of a picture's name, such as a KPI; see `table_plots`.
Pictures = Callable[["ReportData"], Iterable[tuple[str, ...]]]
PlotFunction = Callable[..., Any]
F = TypeVar("F", bound=PlotFunction)

BUILTIN_MODULES = tuple(f"pytest_lpb.report.{name}" for name in ("builtin_plots", "table_plots", "profile_plots"))


@dataclass(frozen=True)
class Plot:
    """A registered plot: `function(trajectory, axes)`, or `function(trajectories, axes)` of several.

    With `pictures` it draws tables: `function(data, parts, axes)` once for each of the pictures.
    """

    name: str
    scope: Scope
    function: PlotFunction
    without_rows: bool = False  # it is given trials without rows too: their worker crashed
    pictures: Pictures | None = None

    @property
    def place(self) -> str:
        """Where the function is defined, `file:line`."""
        code = getattr(self.function, "__code__", None)
        if code is None:
            return f"{type(self.function).__module__}.{type(self.function).__qualname__}"
        return f"{Path(code.co_filename).resolve()}:{code.co_firstlineno}"

    @property
    def builtin(self) -> bool:
        """Whether it comes with pytest-lpb."""
        return getattr(self.function, "__module__", "") in BUILTIN_MODULES


class PlotRegistry:
    """Plots by name. All but tests use `default_registry`."""

    def __init__(self) -> None:
        self._plots: dict[str, Plot] = {}

    def __iter__(self) -> Iterator[Plot]:
        """All plots, as registered."""
        return iter(self._plots.values())

    def plot(self, name: str, scope: Scope = "trial", *, without_rows: bool = False) -> Callable[[F], F]:
        """Register a function that draws on matplotlib axes.

        Args:
            name: names the file and the heading in the report.
            scope: `trial`: function(trajectory, axes); `scenario`, `run`: function(trajectories, axes).
            without_rows: whether it can draw trials without rows (their worker crashed), which are left out else.

        Raises:
            ConfigurationError: a name or scope that is not allowed, or a name that is taken.
        """

        def register(function: F) -> F:
            if not callable(function):
                raise ConfigurationError(f"plot {name!r}: {function!r} is not a function")
            self.add(Plot(name, scope, function, without_rows))
            return function

        return register

    def add(self, entry: Plot) -> None:
        """Register a plot; once more from the same place (a module imported again) replaces it.

        Raises:
            ConfigurationError: the name or scope is not allowed, or the name is taken by another function.
        """
        where = f"plot {entry.name!r} ({entry.place})"
        if not is_name(entry.name) or not entry.name[0].isalpha():
            raise ConfigurationError(f"{where}: a name begins with a letter; allowed: letters, digits, _ . -")
        if entry.scope not in get_args(Scope):
            raise ConfigurationError(f"{where}: scope is {entry.scope!r}; allowed: {listed(get_args(Scope))}")
        known = self._plots.get(entry.name)
        if known is not None and known.place != entry.place:
            raise ConfigurationError(f"{where}: the name is taken by {known.place}; rename one of them")
        self._plots[entry.name] = entry

    def select(self, names: Iterable[str] | None = None) -> list[Plot]:
        """Plots of these names (None: all), each once. Raises ConfigurationError for names not registered."""
        if names is None:
            return list(self)
        wanted = dict.fromkeys(names)
        unknown = [name for name in wanted if name not in self._plots]
        if unknown:
            faults = [f"unknown plot {name!r}{suggestion(name, self._plots)}" for name in unknown]
            raise ConfigurationError("\n".join([*faults, f"plots: {listed(self._plots)}"]))
        return [self._plots[name] for name in wanted]

    @contextmanager
    def preserved(self) -> Iterator[PlotRegistry]:
        """Undo on leaving whatever is registered inside: one pytest session's plots do not reach the next."""
        before = dict(self._plots)
        try:
            yield self
        finally:
            self._plots = before


default_registry = PlotRegistry()
plot = default_registry.plot


@dataclass
class WrittenPlots:
    """Files written, and what went wrong, one line per plot that failed."""

    paths: list[Path] = field(default_factory=list)
    failures: list[str] = field(default_factory=list)


def load_builtin() -> PlotRegistry:
    """Import the built-in plots and return their registry. Raises ConfigurationError: a name is taken."""
    for module in BUILTIN_MODULES:
        import_module(module)
    return default_registry


def write_plots(
    folder: Path,
    names: Iterable[str] | None,
    data: ReportData,
    formats: Sequence[str] = ("png", "pdf"),
    registry: PlotRegistry | None = None,
) -> WrittenPlots:
    """Draw plots into FOLDER/NAME/SCENARIO/PLANNER/seedK.png, FOLDER/NAME/SCENARIO.png or FOLDER/NAME.png.

    Args:
        folder: made when it is missing.
        names: plots to draw; None: all.
        data: the evaluated run.
        formats: file formats of matplotlib.
        registry: where plots are looked up; the default one with the built-in plots when None.

    Raises:
        ConfigurationError: names that are not registered.
    """
    from pytest_lpb.report.drawing import PlotFailure, drawings, save

    written = WrittenPlots()
    for entry in (registry or load_builtin()).select(names):
        for drawing in drawings(entry, data, data.trials):
            target = folder.joinpath(*map(_file_name, (entry.name, *drawing.parts)))
            try:
                written.paths += save(drawing, target, formats)
            except PlotFailure as failure:
                written.failures.append(str(failure))
    return written


def _file_name(part: str) -> str:
    cleaned = re.sub(r"[^A-Za-z0-9_.-]", "_", part)
    return cleaned if cleaned.strip(".") else "_"
