"""The collectors above planners: a scenario file, or a scenario of a study or of an old run."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from pytest_lpb.errors import LpbError, MissingRobotsError, ScenarioError
from pytest_lpb.kpis.registry import default_registry
from pytest_lpb.names import is_name
from pytest_lpb.plugin.items import PlannerCollector
from pytest_lpb.plugin.session import LpbSession, session_of
from pytest_lpb.scenario.draw import check_feasible, parts_drawn
from pytest_lpb.scenario.load import Scenario
from pytest_lpb.study.family import Family, FileFamily

RESERVED_KEY = "all"  # run.summary.ALL: the scenario of rows over all scenarios
FIXED: pytest.StashKey[dict[str, list[str]]] = pytest.StashKey()  # scenarios by part that a flag could not draw
ROBOTS: pytest.StashKey[set[tuple[str, str]]] = pytest.StashKey()  # names and control modes of the run's robots
KEYS: pytest.StashKey[dict[str, Path]] = pytest.StashKey()  # scenario key -> file


class ScenarioFile(pytest.File):
    """A scenario file; its tags are markers of all its trials."""

    def __init__(self, **keywords: Any) -> None:
        super().__init__(**keywords)
        self.family: Family = FileFamily(session_of(self.config).scenario_key(self.path), self.path)

    def collect(self) -> Iterator[PlannerCollector]:
        """One collector per planner. Raises CollectError with file and line for a scenario that is wrong."""
        if not is_name(self.path.stem):
            raise self.CollectError(f"{self.path}: the file's name may have letters, digits, _ . - only; rename it")
        return _planner_collectors(self, self.family)


class SourceFile(pytest.File):
    """A study, or an old run whose problems are run again."""

    def collect(self) -> Iterator[ScenarioCollector]:
        """One collector per scenario."""
        source = session_of(self.config).source
        assert source is not None, "only its file is collected as one"
        for family in source.families:
            yield ScenarioCollector.from_parent(self, name=family.key, family=family)


class ScenarioCollector(pytest.Collector):
    """A scenario of a study or of an old run."""

    def __init__(self, *, family: Family, **keywords: Any) -> None:
        super().__init__(**keywords)
        self.family = family

    def collect(self) -> Iterator[PlannerCollector]:
        """One collector per planner. Raises CollectError with file and line for a scenario that is wrong."""
        return _planner_collectors(self, self.family)


def _planner_collectors(node: pytest.Collector, family: Family) -> Iterator[PlannerCollector]:
    """One collector per planner.

    A scenario whose robot comes with an optional package that is not installed is skipped, with that reason.
    """
    options = session_of(node.config)
    try:
        scenario = _checked(node, family, options)
    except MissingRobotsError as error:
        pytest.skip(str(error), allow_module_level=True)
    except LpbError as error:
        raise node.CollectError(str(error)) from error
    _add_tags(node, scenario)
    for configuration in options.planners:
        yield PlannerCollector.from_parent(node, name=configuration.name, configuration=configuration)


def _checked(node: pytest.Collector, family: Family, options: LpbSession) -> Scenario:
    _claim_key(node, family)
    scenario = family.scenario()
    for name in scenario.success.criteria:
        try:
            default_registry.select([name])
        except LpbError as error:
            raise ScenarioError(f"{scenario.place(('success', name))}: success: {error}") from error
    check_feasible(scenario, options.flags)
    dt = scenario.concrete["environment"]["dt"]
    for configuration in options.planners:
        configuration.steps_per_call(dt)
        configuration.steps_of_delay(dt)
        configuration.parameters_for(scenario.concrete["robot"]["name"], scenario.concrete["robot"]["control"])
    robot = scenario.concrete["robot"]
    node.config.stash.setdefault(ROBOTS, set()).add((robot["name"], robot["control"]))
    fixed = node.config.stash.setdefault(FIXED, {})
    for part in sorted(set(options.flags) - set(parts_drawn(scenario, options.flags))):
        fixed.setdefault(part, []).append(family.key)
    return scenario


def _claim_key(node: pytest.Collector, family: Family) -> None:
    """Results are filed under the scenario's key: no two files may share one."""
    if family.key == RESERVED_KEY:
        raise ScenarioError(f"{family.path}: {family.key!r} stands for all scenarios in tables; rename the file")
    other = node.config.stash.setdefault(KEYS, {}).setdefault(family.key, family.path)
    if other != family.path:
        raise ScenarioError(f"{family.path}: scenario {family.key!r} is also the name of {other}; rename one of them")


def _add_tags(node: pytest.Collector, scenario: Scenario) -> None:
    for tag in scenario.tags:
        try:
            with warnings.catch_warnings():
                # An unregistered tag is no typo to warn of, unless the project asks for strict markers.
                warnings.simplefilter("ignore", pytest.PytestUnknownMarkWarning)
                node.add_marker(tag)
        except pytest.fail.Exception as error:
            place = scenario.place(("tags",))
            raise node.CollectError(f"{place}: tags: {error}; register {tag!r} in ini `markers`") from None
