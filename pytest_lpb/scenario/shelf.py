"""Scenario files of a folder at a glance: what they are about, without loading robots or drawing problems."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from pydantic import ValidationError

from pytest_lpb.documents.reader import read_yaml
from pytest_lpb.documents.recognition import SUFFIXES, is_study
from pytest_lpb.errors import LpbError, ScenarioError
from pytest_lpb.names import listed, suggestion
from pytest_lpb.problem.packages import SCHEME
from pytest_lpb.problem.paths import paths_in
from pytest_lpb.scenario.schema import ScenarioFile
from pytest_lpb.scenario.schema.obstacle import AxisAngle, Obstacle
from pytest_lpb.scenario.schema.registered import scenario_model


@dataclass(frozen=True)
class Entry:
    """One scenario file.

    Attributes:
        name: its path below the folder, without suffix.
        files: further files that it names.
        standing, moving: listed obstacles.
        drawn: least and most obstacles that are drawn without a flag.
        known_failures: planners that its `xfail` names, for all seeds or some.
    """

    name: str
    path: Path
    files: Sequence[Path]
    description: str
    tags: Sequence[str]
    robot: str
    base: str  # empty for one that does not move
    control: str
    trials: int
    standing: int
    moving: int
    drawn: tuple[int, int]
    known_failures: Sequence[str]

    @property
    def difficulty(self) -> int:
        """How many planners are known to fail: among shipped scenarios, those that come with pytest-lpb."""
        return len(self.known_failures)


def scenarios_in(folder: Path) -> list[Entry]:
    """All scenarios of a folder, by name. Raises ScenarioError for a file that is neither one nor a study."""
    return [_entry(path, folder) for path in _files(folder) if not is_study(path)]


def studies_in(folder: Path) -> list[Path]:
    """All study files of a folder."""
    return [path for path in _files(folder) if is_study(path)]


def _files(folder: Path) -> list[Path]:
    return sorted(path for suffix in SUFFIXES for path in folder.rglob(f"*{suffix}"))


def _entry(path: Path, folder: Path) -> Entry:
    try:
        data = read_yaml(path.read_bytes(), str(path)).data
        file = scenario_model().model_validate(data)
    except ValidationError as error:
        raise ScenarioError(f"{path}: {error.error_count()} faults; `pytest --collect-only` names them") from None
    moving = sum(map(_moves, file.obstacles))
    return Entry(
        name=path.relative_to(folder).with_suffix("").as_posix(),
        path=path,
        files=[path.parent / name for name in paths_in(data) if not name.startswith(SCHEME)],
        description=file.description,
        tags=file.tags,
        robot=file.robot.model or Path(file.robot.urdf or "").stem,
        base="" if file.robot.base in (None, "fixed") else file.robot.base,
        control=file.robot.control,
        trials=file.trials,
        standing=len(file.obstacles) - moving,
        moving=moving,
        drawn=_drawn(file),
        known_failures=sorted(file.xfail),
    )


def _moves(obstacle: Obstacle) -> bool:
    turn = obstacle.orientation
    turning = turn.angle if isinstance(turn, AxisAngle) else turn
    return obstacle.position is None or isinstance(turning, str)


def _drawn(file: ScenarioFile) -> tuple[int, int]:
    if file.randomize is None or "obstacles" not in file.randomize.draw:
        return 0, 0
    counts = [group.count for group in file.randomize.obstacles or []]
    return sum(least for least, _ in counts), sum(most for _, most in counts)


def tagged(entries: Iterable[Entry], tags: Collection[str], robot: str | None) -> list[Entry]:
    """Those that have every tag, and the robot. Raises LpbError for a tag or robot that none has."""
    entries = list(entries)
    known = {tag for entry in entries for tag in entry.tags}
    for tag in tags:
        _check_known("tag", tag, known)
    if robot is not None:
        _check_known("robot", robot, {entry.robot for entry in entries})
    return [entry for entry in entries if set(tags) <= set(entry.tags) and robot in (None, entry.robot)]


def named(entries: Iterable[Entry], names: Sequence[str]) -> list[Entry]:
    """Those of these names, or below these folders; all without any. Raises LpbError for a name that none has."""
    entries = list(entries)
    if not names:
        return entries
    found: dict[str, Entry] = {}
    for name in names:
        wanted = name.strip("/").removesuffix(".yaml")
        matching = [entry for entry in entries if entry.name == wanted or entry.name.startswith(f"{wanted}/")]
        if not matching:
            folders = {entry.name.rpartition("/")[0] for entry in entries}
            near = suggestion(wanted, {entry.name for entry in entries} | folders)
            raise LpbError(f"no scenario {name!r} comes with pytest-lpb{near}; `lpb-scenarios list` names them")
        found |= {entry.name: entry for entry in matching}
    return list(found.values())


def _check_known(kind: str, name: str, known: Collection[str]) -> None:
    if name not in known:
        raise LpbError(f"no scenario has the {kind} {name!r}{suggestion(name, known)}; there are {listed(known)}")


HEADS = ("scenario", "robot", "control", "trials", "obstacles", "difficulty", "tags")


def table(entries: Iterable[Entry]) -> list[tuple[str, ...]]:
    """Rows of text, heads first."""
    return [HEADS, *map(_cells, entries)]


def _cells(entry: Entry) -> tuple[str, ...]:
    failing = f" ({', '.join(entry.known_failures)})" if entry.known_failures else ""
    return (
        entry.name,
        f"{entry.robot} ({entry.base})" if entry.base else entry.robot,
        entry.control,
        str(entry.trials),
        _obstacles(entry),
        f"{entry.difficulty}{failing}",
        ", ".join(entry.tags),
    )


def _obstacles(entry: Entry) -> str:
    """Such as `2 + 1 moving + 3 to 5 drawn`."""
    least, most = entry.drawn
    parts = [
        str(entry.standing) if entry.standing else "",
        f"{entry.moving} moving" if entry.moving else "",
        f"{least} drawn" if least == most and most else f"{least} to {most} drawn" if most else "",
    ]
    return " + ".join(part for part in parts if part) or "none"
