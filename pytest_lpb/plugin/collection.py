"""Which files are scenarios, and the tree of items: scenario file > planner > seed."""

from __future__ import annotations

import os
import re
import warnings
from collections.abc import Collection, Iterable
from pathlib import Path

import pytest

from pytest_lpb.documents.recognition import SUFFIXES, is_study
from pytest_lpb.names import suggestion
from pytest_lpb.planner.configuration import PlannerConfiguration
from pytest_lpb.plugin.items import TrialItem
from pytest_lpb.plugin.scenarios import FIXED, ROBOTS, ScenarioFile, SourceFile
from pytest_lpb.plugin.session import LpbSession
from pytest_lpb.run.folder import RUN_FILE
from pytest_lpb.shipped import shipped_folder

MAX_NAMED = 5  # scenarios that a warning names

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

    def pytest_collect_file(self, file_path: Path, parent: pytest.Collector) -> ScenarioFile | SourceFile | None:
        """A scenario file for a YAML file that is named, or that matches `lpb_scenarios`; or the run's source."""
        source = self._session.source
        node_id = self._session.node_id_of(file_path)
        if source is not None and file_path == source.path:
            chosen: SourceFile = SourceFile.from_parent(parent, path=file_path, nodeid=node_id)
            return chosen
        if file_path.suffix not in SUFFIXES or not self._is_scenario(file_path, parent.config):
            return None
        node: ScenarioFile = ScenarioFile.from_parent(parent, path=file_path, nodeid=node_id)
        return node

    def _is_scenario(self, path: Path, config: pytest.Config) -> bool:
        if path in self._named_files(config):
            return True
        # Studies are run when they are named only.
        return self._matches(path, config) and not self._lies_in_shut(path, config) and not is_study(path)

    @pytest.hookimpl(tryfirst=True)
    def pytest_collection_modifyitems(self, config: pytest.Config, items: list[pytest.Item]) -> None:
        """A run that is finished later has the trials that it was to have, and no others."""
        planned = self._session.planned
        if planned is None:
            return
        kept: list[pytest.Item] = []
        dropped: list[pytest.Item] = []
        for item in items:
            (kept if isinstance(item, TrialItem) and item.key in planned else dropped).append(item)
        if dropped:
            config.hook.pytest_deselected(items=dropped)
            items[:] = kept

    def _lies_in_shut(self, path: Path, config: pytest.Config) -> bool:
        """Whether a folder above is shut: pytest walks one that is named, or on the way to a file that is."""
        return any(self._is_shut(folder, config) for folder in path.parents if folder.is_relative_to(config.rootpath))

    def pytest_collection_finish(self, session: pytest.Session) -> None:
        """Say once what options and planner files ask for in vain; no filter of warnings makes it an error."""
        config = session.config
        if getattr(config, "workerinput", {"workerid": "gw0"})["workerid"] != "gw0":
            return
        robots: set[tuple[str, str]] = config.stash.get(ROBOTS, set())
        if unmatched := unmatched_robots(self._session.planners, robots):
            _warn(config, unmatched)
        for part, scenarios in config.stash.get(FIXED, {}).items():
            names = ", ".join(scenarios[:MAX_NAMED]) + (
                f" and {len(scenarios) - MAX_NAMED} more" if scenarios[MAX_NAMED:] else ""
            )
            text = f"--lpb-random-{part}: no ranges in `randomize: {part}`, it stays fixed in {names}"
            _warn(config, text)

    def _named_files(self, config: pytest.Config) -> set[Path]:
        if self._named is None:
            folder = config.invocation_params.dir
            texts = (os.path.normpath(folder / argument.partition("::")[0]) for argument in config.args)
            # pytest takes `..` out of paths in the same way, without looking at links.
            files = {Path(text) for text in texts if text.endswith(SUFFIXES)}
            source = self._session.source
            self._named = files if source is None else {*files, source.path}
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


def _warn(config: pytest.Config, text: str) -> None:
    message = warnings.WarningMessage(pytest.PytestWarning(text), pytest.PytestWarning, __file__, 0)
    config.hook.pytest_warning_recorded.call_historic(
        kwargs={"warning_message": message, "when": "collect", "nodeid": "", "location": None}
    )


def _written_for_this_run(planner: Path | None) -> bool:
    """Whether a planner file is the user's: shipped ones are for all robots, copies in a run folder for those there."""
    return planner is None or not (
        planner.parent == shipped_folder("planners") or (planner.parent.parent / RUN_FILE).is_file()
    )


def unmatched_robots(planners: Iterable[PlannerConfiguration], robots: Collection[tuple[str, str]]) -> str:
    """Keys of `per_robot` in users' planner files that no robot of the run matches, in one line; empty without any.

    Args:
        planners: of the run.
        robots: names and control modes of the run's robots; none: nothing was collected.
    """
    keys = {key for name, control in robots for key in (name, f"@{control}", f"{name}@{control}")}
    told = [
        f"{key!r} of planner {planner.name!r}{hint and f' ({hint})'}"
        for planner in planners
        if _written_for_this_run(planner.path)
        for key in planner.per_robot
        if key not in keys
        for hint in [suggestion(key, keys).removeprefix("; ")]
    ]
    if not told or not robots:
        return ""
    shown = ", ".join(told[:MAX_NAMED]) + (f" and {len(told) - MAX_NAMED} more" if told[MAX_NAMED:] else "")
    named = ", ".join(sorted(f"{name}@{control}" for name, control in robots)[:MAX_NAMED])
    return f"per_robot: no robot of this run matches {shown}; there are {named}"


def glob_pattern(glob: str) -> re.Pattern[str]:
    """A glob as a regular expression on posix paths; `**/` is any number of folders, `*` never crosses one."""
    pieces = {"**/": "(?:.*/)?", "**": ".*", "*": "[^/]*", "?": "[^/]"}
    tokens = re.split(r"(\*\*/|\*\*|\*|\?)", glob)
    return re.compile("".join(pieces.get(token, re.escape(token)) for token in tokens))
