"""Which files are scenarios, and the tree of items: scenario file > planner > seed."""

from __future__ import annotations

import os
import re
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
from pytest_lpb.run.folder import RUN_FILE
from pytest_lpb.scenario.draw import check_feasible, parts_drawn
from pytest_lpb.scenario.load import Scenario, load_scenario

FIXED: pytest.StashKey[dict[str, list[str]]] = pytest.StashKey()  # scenarios by part that a flag could not draw
MAX_NAMED = 5  # scenarios that a warning names
SUFFIXES = (".yaml", ".yml")
RESERVED_KEY = "all"  # run.summary.ALL: the scenario of rows over all scenarios
KEYS: pytest.StashKey[dict[str, Path]] = pytest.StashKey()  # scenario key -> file

# Tags that shipped scenarios use, registered as markers; users register their own in ini `markers`.
STANDARD_TAGS = {
    "planar": "in the plane",
    "spatial": "in space",
    "point": "a point robot",
    "arm": "a planar arm or a manipulator",
    "differential_drive": "a cart with two driven wheels",
    "bicycle": "a car",
    "mobile_manipulator": "an arm on a moving base",
    "static": "nothing moves but the robot",
    "moving": "obstacles or goals move",
    "random": "problems are drawn",
    "narrow": "passages hardly wider than the robot",
    "trap": "a local minimum between start and goal",
    "velocity": "velocity control",
    "paper": "problems of Local Planner Bench (Spahn et al., 2022)",
}


def register_tags(config: pytest.Config) -> None:
    """Register the tags of shipped scenarios as markers."""
    for tag, meaning in STANDARD_TAGS.items():
        config.addinivalue_line("markers", f"{tag}: scenario tag: {meaning}")


class CollectionPlugin:
    """Collects scenario files while planners are chosen."""

    def __init__(self, session: LpbSession) -> None:
        self._session = session
        self._named: set[Path] | None = None
        self._patterns: list[re.Pattern[str]] | None = None
        self._shut: dict[Path, bool] = {}

    @pytest.hookimpl(tryfirst=True)
    def pytest_ignore_collect(self, collection_path: Path, config: pytest.Config) -> bool | None:
        """Never walk run folders, the reports folder and hidden folders, but on the way to a file that is named."""
        if not self._is_shut(collection_path, config):
            return None
        return not any(named.is_relative_to(collection_path) for named in self._named_files(config)) or None

    def _is_shut(self, path: Path, config: pytest.Config) -> bool:
        if path not in self._shut:
            self._shut[path] = path != config.rootpath and path.is_dir() and self._is_private(path)
        return self._shut[path]

    def _is_private(self, path: Path) -> bool:
        return path.name.startswith(".") or path == self._session.reports or (path / RUN_FILE).is_file()

    def pytest_collect_file(self, file_path: Path, parent: pytest.Collector) -> ScenarioFile | None:
        """A scenario file for a YAML file that is named, or that matches `lpb_scenarios`."""
        if file_path.suffix not in SUFFIXES:
            return None
        config = parent.config
        if file_path in self._named_files(config) or (
            self._matches(file_path, config) and not self._lies_in_shut(file_path, config)
        ):
            node_id = self._session.node_id_of(file_path)
            node: ScenarioFile = ScenarioFile.from_parent(parent, path=file_path, nodeid=node_id)
            return node
        return None

    def _lies_in_shut(self, path: Path, config: pytest.Config) -> bool:
        """Whether a folder above is shut: pytest walks one that is named, or on the way to a file that is."""
        return any(self._is_shut(folder, config) for folder in path.parents if folder.is_relative_to(config.rootpath))

    def pytest_collection_finish(self, session: pytest.Session) -> None:
        """One warning per flag that could not draw, in one process; no filter of warnings makes it an error."""
        config = session.config
        if getattr(config, "workerinput", {"workerid": "gw0"})["workerid"] != "gw0":
            return
        for part, scenarios in config.stash.get(FIXED, {}).items():
            names = ", ".join(scenarios[:MAX_NAMED]) + (
                f" and {len(scenarios) - MAX_NAMED} more" if scenarios[MAX_NAMED:] else ""
            )
            text = f"--lpb-random-{part}: no ranges in `randomize: {part}`, it stays fixed in {names}"
            message = warnings.WarningMessage(pytest.PytestWarning(text), pytest.PytestWarning, __file__, 0)
            config.hook.pytest_warning_recorded.call_historic(
                kwargs={"warning_message": message, "when": "collect", "nodeid": "", "location": None}
            )

    def _named_files(self, config: pytest.Config) -> set[Path]:
        if self._named is None:
            folder = config.invocation_params.dir
            texts = (os.path.normpath(folder / argument.partition("::")[0]) for argument in config.args)
            # pytest takes `..` out of paths in the same way, without looking at links.
            self._named = {Path(text) for text in texts if text.endswith(SUFFIXES)}
        return self._named

    def _matches(self, path: Path, config: pytest.Config) -> bool:
        if self._patterns is None:
            self._patterns = [glob_pattern(glob) for glob in config.getini("lpb_scenarios")]
        candidates = []
        if path.is_relative_to(config.rootpath):
            candidates.append(path.relative_to(config.rootpath).as_posix())
        if config.inipath is None:
            # Without an ini file the rootdir is what the arguments share, perhaps a scenarios folder itself.
            candidates.append(path.as_posix())
        return any(pattern.fullmatch(text) for pattern in self._patterns for text in candidates)


def glob_pattern(glob: str) -> re.Pattern[str]:
    """A glob as a regular expression on posix paths; `**/` is any number of folders, `*` never crosses one."""
    pieces = {"**/": "(?:.*/)?", "**": ".*", "*": "[^/]*", "?": "[^/]"}
    tokens = re.split(r"(\*\*/|\*\*|\*|\?)", glob)
    return re.compile("".join(pieces.get(token, re.escape(token)) for token in tokens))


class ScenarioFile(pytest.File):
    """A scenario file; its tags are markers of all its trials."""

    def __init__(self, **keywords: Any) -> None:
        super().__init__(**keywords)
        self.scenario: Scenario | None = None

    @property
    def session_options(self) -> LpbSession:
        """The run's options."""
        return session_of(self.config)

    def collect(self) -> Iterator[PlannerCollector]:
        """One collector per planner. Raises CollectError with file and line for a scenario that is wrong.

        A scenario whose robot comes with an optional package that is not installed is skipped, with that reason.
        """
        options = self.session_options
        try:
            self.scenario = self._checked(options)
        except MissingRobotsError as error:
            pytest.skip(str(error), allow_module_level=True)
        except LpbError as error:
            raise self.CollectError(str(error)) from error
        self._add_tags(self.scenario)
        for configuration in options.planners:
            yield PlannerCollector.from_parent(self, name=configuration.name, configuration=configuration)

    def _checked(self, options: LpbSession) -> Scenario:
        if not is_name(self.path.stem):
            raise ScenarioError(f"{self.path}: the file's name may have letters, digits, _ . - only; rename it")
        self._claim_key(options)
        scenario = load_scenario(self.path)
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
        self._note_fixed_parts(scenario, options)
        return scenario

    def _claim_key(self, options: LpbSession) -> None:
        """Results are filed under the scenario's key: no two files may share one."""
        key = options.scenario_key(self.path)
        if key == RESERVED_KEY:
            raise ScenarioError(f"{self.path}: {key!r} stands for all scenarios in tables; rename the file")
        other = self.config.stash.setdefault(KEYS, {}).setdefault(key, self.path)
        if other != self.path:
            raise ScenarioError(f"{self.path}: scenario {key!r} is also the name of {other}; rename one of them")

    def _note_fixed_parts(self, scenario: Scenario, options: LpbSession) -> None:
        fixed = self.config.stash.setdefault(FIXED, {})
        for part in sorted(set(options.flags) - set(parts_drawn(scenario, options.flags))):
            fixed.setdefault(part, []).append(options.scenario_key(self.path))

    def _add_tags(self, scenario: Scenario) -> None:
        for tag in scenario.tags:
            try:
                with warnings.catch_warnings():
                    # An unregistered tag is no typo to warn of, unless the project asks for strict markers.
                    warnings.simplefilter("ignore", pytest.PytestUnknownMarkWarning)
                    self.add_marker(tag)
            except pytest.fail.Exception as error:
                place = scenario.place(("tags",))
                raise self.CollectError(f"{place}: tags: {error}; register {tag!r} in ini `markers`") from None
