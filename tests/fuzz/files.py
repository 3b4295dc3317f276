"""Mutants of shipped scenario, planner and study files, and of small URDF and mesh files: read, or refused in words.

python -m tests.fuzz.files COUNT SEED    prints what is wrong, and exits 1
"""

from __future__ import annotations

import random
import re
import shutil
import sys
import tempfile
import time
import traceback
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

from pytest_lpb.environment.environment import ScenarioEnvironment
from pytest_lpb.errors import LpbError
from pytest_lpb.planner.files import read_planner
from pytest_lpb.scenario.draw import check_feasible, draw_problem
from pytest_lpb.scenario.load import load_scenario
from pytest_lpb.shipped import shipped_folder
from pytest_lpb.study.study import read_study
from tests.fuzz.mutation import mutant
from tests.fuzz.parts import PARTS, write_parts

SLOW_S = 2.0  # of processor time: machines are shared
STEPS = 3  # of a trial, from mutants that are read
NAME = "mutant_"  # and the suffix


class Finding(NamedTuple):
    """What is wrong with how a mutant was taken."""

    original: str
    number: int
    what: str
    content: bytes


def _scenario(path: Path) -> None:
    scenario = load_scenario(path)
    check_feasible(scenario)
    try:
        problem = draw_problem(scenario, scenario.seed, (), "mutant")
    except LpbError:
        # The file is sound, its problem is not: told by name, without a line.
        return
    environment = ScenarioEnvironment(problem=problem)
    try:
        while environment.row < STEPS and not environment.ended:
            environment.step([0.0] * problem.robot.n_actions)
    except LpbError:
        return  # a robot that diverges is the outcome of a trial
    finally:
        environment.close()


def _planner(path: Path) -> None:
    read_planner(path, "mutant").check()


def _study(path: Path) -> None:
    study = read_study(path)
    study.references()
    study.families(lambda file: file.stem)


def _part(path: Path) -> None:
    """A scenario that names a URDF or a mesh."""
    _scenario(path.with_name(f"names{path.suffix}.yaml"))


READERS: dict[str, Callable[[Path], None]] = {
    "scenarios": _scenario,
    "planners": _planner,
    "studies": _study,
    "parts": _part,
}
# How often each kind is chosen.
KINDS = ("scenarios",) * 3 + ("planners", "studies", "parts")


def kind_of(path: Path) -> str:
    """Which reader a file is for."""
    if path.parent.name == PARTS:
        return "parts"
    if path.parent.name == "studies":
        return "studies"
    return "planners" if "planners" in path.parts else "scenarios"


def originals(folder: Path) -> list[Path]:
    """Copies of all shipped YAML files in a folder, with what belongs to them; and URDF and mesh files."""
    for name in ("scenarios", "planners"):
        shutil.copytree(shipped_folder(name), folder / name)
    shipped = sorted(path for path in folder.rglob("*.yaml"))
    return [*shipped, *write_parts(folder / PARTS, NAME)]


def findings(count: int, seed: int, folder: Path, slow_s: float = SLOW_S) -> Iterator[Finding]:
    """Read `count` mutants; yields what should not be."""
    files = originals(folder)
    # Kinds take turns: there are many more scenarios than studies.
    by_kind = {kind: [path for path in files if kind_of(path) == kind] for kind in READERS}
    before = sorted(folder.rglob("*"))
    for number in range(count):
        source = random.Random(f"{seed}:{number}")
        kind = source.choice(KINDS)
        original = source.choice(by_kind[kind])
        content = mutant(original, source)
        path = original.with_name(f"{NAME}{original.suffix}")
        path.write_bytes(content)
        started = time.process_time()
        what = _fault(READERS[kind], path)
        took = time.process_time() - started
        path.unlink()
        if not what and took > slow_s:
            what = f"took {took:.1f} s"
        if what:
            yield Finding(original.relative_to(folder).as_posix(), number, what, content)
    left = sorted(set(folder.rglob("*")) - set(before))
    if left:
        yield Finding("", count, f"left behind: {left}", b"")


def _fault(read: Callable[[Path], None], path: Path) -> str:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            read(path)
    except LpbError as error:
        lines = str(error).splitlines()
        first = lines[0] if lines else ""
        return "" if re.match(r".+\.(yaml|urdf|obj|csv):\d+: ", first) else f"no file and line: {str(error)[:300]!r}"
    except BaseException:
        return traceback.format_exc()
    return ""


def main(arguments: list[str]) -> int:
    """Fuzz from the command line."""
    count, seed = (int(text) for text in arguments)
    found = 0
    with tempfile.TemporaryDirectory() as folder:
        for finding in findings(count, seed, Path(folder)):
            found += 1
            print(f"--- {finding.original} #{finding.number}: {finding.what}")
            Path(f"/tmp/mutant-{seed}-{finding.number}{Path(finding.original).suffix}").write_bytes(finding.content)
    print(f"{count} mutants, {found} findings")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
