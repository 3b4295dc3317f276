"""Reads a study file."""

from __future__ import annotations

import fnmatch
import glob
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import takewhile
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from pytest_lpb.bounded import read_bounded
from pytest_lpb.documents.faults import Key, capped, key_path
from pytest_lpb.documents.reader import MAX_BYTES, Document, read_yaml
from pytest_lpb.documents.recognition import SUFFIXES, is_study
from pytest_lpb.errors import ConfigurationError, LpbError
from pytest_lpb.names import is_name, listed, suggestion
from pytest_lpb.planner.configuration import PlannerConfiguration
from pytest_lpb.planner.files import parted, with_path
from pytest_lpb.problem.allowed import project_of, refusal
from pytest_lpb.scenario.load import shown_path
from pytest_lpb.scenario.messages import faults_of
from pytest_lpb.study.family import FileFamily
from pytest_lpb.study.schema import StudyFile
from pytest_lpb.study.sweep import combinations, planner_variants, scenario_variants, suffix

EXPECTED = "a study is a mapping that begins with `study: what it is about`"


@dataclass(frozen=True)
class Study:
    """A study file, checked; its planners and scenarios are found when they are asked for."""

    path: Path
    content: StudyFile
    document: Document = field(repr=False, compare=False)

    def place(self, loc: Sequence[Key]) -> str:
        """`file:line: key` of a key path, as messages begin."""
        return f"{shown_path(self.path)}:{self.document.line_of(loc)}: {key_path(loc)}"

    def references(self) -> list[str]:
        """References of its planners, paths absolute. Raises ConfigurationError for one outside of its project."""
        return [
            with_path(reference, partial(self._named, ("planners", index)))
            for index, reference in enumerate(self.content.planners)
        ]

    def baseline(self) -> str | None:
        """The gate's baseline, its path absolute. Raises ConfigurationError for one outside of its project."""
        gate = self.content.gate
        if gate is None or gate.baseline.startswith("planner:"):
            return None if gate is None else gate.baseline
        return self._named(("gate", "baseline"), gate.baseline)

    def _named(self, loc: Sequence[Key], path: str) -> str:
        """A path that the study names, absolute; as those of a scenario, it lies in the file's own project."""
        found = self.path.parent / path
        refused = refusal(found, project_of(self.path))
        if refused:
            raise ConfigurationError(f"{self.place(loc)}: {found} {refused}")
        return str(found)

    def planners(self, found: Sequence[PlannerConfiguration]) -> list[PlannerConfiguration]:
        """Planners with the variants of the sweeps in their place. Raises ConfigurationError.

        Args:
            found: the planners chosen; sweeps of the study's other planners are left out.
        """
        variants: dict[str, list[PlannerConfiguration]] = {}
        own = {parted(reference)[0] for reference in self.content.planners}
        for index, sweep in enumerate(self.content.sweep):
            if sweep.planner is None or sweep.parameters is None:
                continue
            place = self.place(("sweep", index, "planner"))
            planner = next((planner for planner in found if planner.name == parted(sweep.planner)[0]), None)
            if planner is None and parted(sweep.planner)[0] in own:
                continue  # the command line chose others
            if planner is None:
                names = [planner.name for planner in found]
                hint = suggestion(sweep.planner, names)
                raise ConfigurationError(
                    f"{place}: found {sweep.planner!r}{hint}; allowed are the study's planners: {listed(names)}"
                )
            try:
                variants.setdefault(planner.name, []).extend(planner_variants(planner, sweep.parameters))
            except ConfigurationError as error:
                raise ConfigurationError(f"{self.place(('sweep', index, 'parameters'))}: {error}") from None
        chosen = [variant for planner in found for variant in variants.get(planner.name, [planner])]
        _check_names([planner.name for planner in chosen], "planner", str(self.path))
        return chosen

    def families(self, key_of: Callable[[Path], str]) -> list[FileFamily]:
        """Families of its scenarios, with the variants of the sweeps in their place. Raises ConfigurationError.

        Args:
            key_of: the key of a scenario file.
        """
        plain = [FileFamily(key_of(path), path) for path in self._scenario_files()]
        variants: dict[str, list[FileFamily]] = {}
        for index, sweep in enumerate(self.content.sweep):
            if sweep.knobs is None:
                continue
            globs = sweep.scenarios or ["*"]
            swept = [family for family in plain if any(fnmatch.fnmatchcase(family.key, text) for text in globs)]
            if not swept:
                place = self.place(("sweep", index, "scenarios"))
                keys = listed(family.key for family in plain)
                raise ConfigurationError(f"{place}: found {', '.join(globs)}; the study's scenarios are {keys}")
            for family in swept:
                variants.setdefault(family.key, []).extend(
                    scenario_variants(family, sweep.knobs, self.place(("sweep", index, "knobs")))
                )
        chosen = [variant for family in plain for variant in variants.get(family.key, [family])]
        _check_names([family.key for family in chosen], "scenario", str(self.path))
        return chosen

    def _scenario_files(self) -> list[Path]:
        found: dict[Path, None] = {}
        for index, pattern in enumerate(self.content.scenarios):
            self._check_pattern(("scenarios", index), pattern)
            # Only what the study says is a pattern, not what its folder is called; it may be absolute.
            whole = os.path.join(glob.escape(str(self.path.parent)), pattern)  # noqa: PTH118 - no path, a pattern
            paths = sorted(glob.glob(whole, recursive=True))  # noqa: PTH207 - absolute ones too
            files = [Path(os.path.normpath(path)) for path in paths if path.endswith(SUFFIXES)]
            scenarios = [path for path in files if path.is_file() and not is_study(path)]
            if not scenarios:
                place = self.place(("scenarios", index))
                raise ConfigurationError(
                    f"{place}: found {pattern!r}; no scenario file matches it below {self.path.parent}"
                )
            for scenario in scenarios:
                self._named(("scenarios", index), str(scenario))
            found |= dict.fromkeys(scenarios)
        return list(found)

    def _check_pattern(self, loc: Sequence[Key], pattern: str) -> None:
        """Raise ConfigurationError for a glob that would walk through folders outside of the project."""
        parts = Path(pattern).parts
        fixed = list(takewhile(lambda part: not glob.has_magic(part), parts))
        self._named(loc, str(Path(*fixed)))
        if ".." in parts[len(fixed) :]:
            raise ConfigurationError(f"{self.place(loc)}: found {pattern!r}; .. comes before wildcards only")

    def swept(self, families: Sequence[FileFamily]) -> dict[str, Any]:
        """What run.json says of sweeps: for each variant of planners and scenarios, what it is of, and its values."""
        planners = {
            f"{base}{suffix(values)}": {"of": base, "values": values}
            for sweep in self.content.sweep
            if sweep.planner is not None and sweep.parameters is not None
            for base in [parted(sweep.planner)[0]]
            for values in combinations(sweep.parameters)
        }
        scenarios = {
            family.key: {"of": family.base, "values": {change.name: change.value for change in family.changes}}
            for family in families
            if family.changes
        }
        return {"planners": planners, "scenarios": scenarios} if planners or scenarios else {}


def read_study(path: Path) -> Study:
    """Read a study file. Raises ConfigurationError: one `file:line: key: ...` per fault."""
    name = shown_path(path)
    content = read_bounded(path, MAX_BYTES, ConfigurationError, f"{name}:1")
    try:
        document = read_yaml(content, name, EXPECTED)
    except LpbError as error:
        raise ConfigurationError(str(error)) from None
    try:
        file = StudyFile.model_validate(document.data)
    except ValidationError as error:
        faults = [
            f"{name}:{document.line_of(fault.loc)}: {key_path(fault.loc)}: {fault.message}"
            for fault in faults_of(error, StudyFile, document.data)
        ]
        raise ConfigurationError("\n".join(capped(faults))) from None
    study = Study(path, file, document)
    _check_sweeps(study)
    return study


def _check_sweeps(study: Study) -> None:
    """Raise ConfigurationError for sweeps of nothing, or of two things at once."""
    for index, sweep in enumerate(study.content.sweep):
        of_planner = sweep.planner is not None and sweep.parameters is not None
        halves = (sweep.planner is None) != (sweep.parameters is None)
        if halves or of_planner == (sweep.knobs is not None) or (of_planner and sweep.scenarios):
            raise ConfigurationError(
                f"{study.place(('sweep', index))}: a sweep has either `planner` and `parameters`, "
                "or `knobs` and perhaps `scenarios`"
            )


def _check_names(names: Sequence[str], what: str, where: str) -> None:
    for name in names:
        if not all(is_name(part) for part in name.split("/")):
            raise ConfigurationError(f"{where}: {what} {name!r}: a variant's name may have at most 100 characters")
        if names.count(name) > 1:
            raise ConfigurationError(
                f"{where}: {what} {name!r} comes twice; sweep values must differ in letters, digits, _ . -"
            )
