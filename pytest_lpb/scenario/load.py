"""Load a scenario file: a family of problems, ready to draw from."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from operator import itemgetter
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from pytest_lpb.documents.faults import Fault, Key, capped, key_path
from pytest_lpb.documents.reader import MAX_BYTES, Document, read_yaml
from pytest_lpb.errors import MissingRobotsError, ScenarioError
from pytest_lpb.problem.criterion import Criterion, parse_criterion
from pytest_lpb.problem.paths import with_absolute_paths
from pytest_lpb.scenario.allowed import escapes
from pytest_lpb.scenario.canonical import Plain, concrete_form, randomize_form
from pytest_lpb.scenario.checks import check
from pytest_lpb.scenario.messages import faults_of, valid_parts
from pytest_lpb.scenario.robots import structure_of
from pytest_lpb.scenario.schema import ScenarioFile
from pytest_lpb.scenario.schema.randomize import Randomize
from pytest_lpb.scenario.schema.registered import scenario_model
from pytest_lpb.scenario.schema.success import ExpectedFailure


@dataclass(frozen=True)
class SuccessCriteria:
    """When a trial is a success, besides every tolerance and no violation.

    Attributes:
        hold_time: [s] within every tolerance, or `end`: to the last row.
        rate: success rate required of a planner, if any.
        criteria: bounds on KPIs by name; whether the KPIs exist is not known here.
    """

    hold_time: float | str
    rate: Criterion | None
    criteria: Mapping[str, Criterion]


@dataclass(frozen=True)
class XFail:
    """A failure that is known: of these outcomes and seeds, or (None) of any."""

    reason: str
    outcomes: tuple[str, ...] | None
    seeds: tuple[int, ...] | None


@dataclass(frozen=True)
class Scenario:
    """A scenario file, checked, with every default filled in.

    Attributes:
        path: the file.
        source: of a concrete problem, what it was drawn from.
        seed: first seed.
        trials: number of seeds.
        xfail: known failures by planner.
        randomize: ranges by part: start {q}, goal [ranges] or {q}, obstacles [groups]; empty without any.
        draw: parts drawn without a flag.
        keep_obstacles: whether listed obstacles stay beside drawn ones.
        margin: [m] free space around the robot at a drawn start and goal.
        concrete: what `Problem.from_dict` reads; plain data, not to be changed.
        file_hash: SHA-256 of the file's bytes, in hexadecimal.
    """

    path: Path
    description: str
    source: str | None
    tags: tuple[str, ...]
    seed: int
    trials: int
    xfail: Mapping[str, XFail]
    success: SuccessCriteria
    randomize: Plain
    draw: tuple[str, ...]
    keep_obstacles: bool
    margin: float
    concrete: Plain
    file_hash: str
    document: Document = field(repr=False, compare=False)

    def line_of(self, loc: Sequence[Key]) -> int:
        """Line (1-based) of a key path such as `("goal", 0, "target")`, or of what encloses it."""
        return self.document.line_of(loc)

    def place(self, loc: Sequence[Key]) -> str:
        """`file:line` of a key path, as error messages begin."""
        return f"{shown_path(self.path)}:{self.line_of(loc)}"


def load_scenario(path: Path | str, changes: Sequence[Callable[[Plain], Plain]] = ()) -> Scenario:
    """Load a scenario file.

    Args:
        path: the file.
        changes: what a sweep makes of its content before it is checked, in this order.

    Raises:
        ScenarioError: one `file:line: key: what was found, what is allowed` per fault, all at once.
        MissingRobotsError: the robot comes with a package that is not installed, so nothing else can be checked.
    """
    path = Path(path)
    name = shown_path(path)
    content = _content(path, name)
    document = read_yaml(content, name)
    for change in changes:
        document = replace(document, data=change(document.data))
    document = replace(document, data=with_absolute_paths(document.data, path.absolute().parent))
    file = _checked(document, name, escapes(document.data, path))
    structure = structure_of(file.robot)
    assert structure is not None, "the checks let robots of known models pass only"
    concrete = concrete_form(file, structure)
    randomize = file.randomize or Randomize()
    return Scenario(
        path=path,
        description=file.description,
        source=file.source,
        tags=tuple(file.tags),
        seed=file.seed,
        trials=file.trials,
        xfail={planner: _xfail(entry) for planner, entry in file.xfail.items()},
        success=_criteria(concrete["success"]),
        randomize=randomize_form(randomize),
        draw=tuple(randomize.draw),
        keep_obstacles=randomize.keep_obstacles,
        margin=randomize.margin,
        concrete=concrete,
        file_hash=hashlib.sha256(content).hexdigest(),
        document=document,
    )


def shown_path(path: Path) -> str:
    """How messages call a file: relative to the working directory when it lies below it."""
    path = path.absolute()
    working = Path.cwd()
    return path.relative_to(working).as_posix() if path.is_relative_to(working) else str(path)


def _content(path: Path, name: str) -> bytes:
    try:
        with path.open("rb") as file:
            return file.read(MAX_BYTES + 1)
    except OSError as error:
        raise ScenarioError(f"{name}:1: cannot be read: {error.strerror or error}") from None


def _checked(document: Document, name: str, escaping: Sequence[Fault]) -> ScenarioFile:
    if escaping:
        # Not even looked at: what such a file holds must not show in messages.
        raise ScenarioError(*capped([_line(name, document.line_of(fault.loc), fault) for fault in escaping]))
    faults: list[Fault] = []
    model = scenario_model()
    try:
        file = model.model_validate(document.data)
        wrong: frozenset[str] = frozenset()
    except ValidationError as error:
        faults = faults_of(error, model, document.data)
        wrong = frozenset(str(fault.loc[0]) for fault in faults if fault.loc)
        file = model.model_construct(**valid_parts(model, document.data, set(wrong)))
    try:
        faults += check(file, wrong)
    except MissingRobotsError as error:
        place = ("robot", "model")
        raise MissingRobotsError(_line(name, document.line_of(place), Fault(place, str(error)))) from None
    if faults:
        placed = sorted(((document.line_of(fault.loc), fault) for fault in faults), key=itemgetter(0))
        lines = dict.fromkeys(_line(name, line, fault) for line, fault in placed)
        raise ScenarioError(*capped(list(lines)))
    return file


def _line(name: str, line: int, fault: Fault) -> str:
    key = f"{key_path(fault.loc)}: " if fault.loc else ""
    return f"{name}:{line}: {key}{fault.message}"


def _xfail(entry: ExpectedFailure) -> XFail:
    return XFail(
        reason=entry.reason,
        outcomes=None if entry.outcomes is None else tuple(entry.outcomes),
        seeds=None if entry.seeds is None else tuple(entry.seeds),
    )


def _criteria(success: Mapping[str, Any]) -> SuccessCriteria:
    criteria = {key: parse_criterion(text) for key, text in success.items() if key != "hold_time"}
    return SuccessCriteria(success["hold_time"], criteria.pop("rate", None), criteria)
