"""Files named `package://NAME/..`: found in the folders above the file that names them, then where ROS has packages.

`AMENT_PREFIX_PATH` (ROS 2) names prefixes whose packages are in `share/NAME`; `ROS_PACKAGE_PATH` (ROS 1, source trees)
names folders with packages at any depth below, each told by its `package.xml`. Nothing is written there. Whether a file
that is found may be used is decided elsewhere (`allowed.py`).
"""

from __future__ import annotations

import json
import os
import re
from collections.abc import Iterator, Mapping
from functools import cached_property
from pathlib import Path

SCHEME = "package://"
AMENT = "AMENT_PREFIX_PATH"
ROS = "ROS_PACKAGE_PATH"
MANIFEST = "package.xml"
INDEX = "lpb_packages.json"  # of copies in a run folder: where those of packages are
MAX_INDEX_BYTES = 10_000_000
IGNORED = ("CATKIN_IGNORE", "COLCON_IGNORE", "AMENT_IGNORE")  # files that tell colcon and rospack to pass a folder by
MAX_FOLDERS = 20_000  # of ROS_PACKAGE_PATH that are looked at
MAX_MANIFEST_BYTES = 100_000
_NAME = re.compile(rb"<name>\s*([^<\s]+)\s*</name>")


def environment() -> tuple[str, str]:
    """The variables that say where ROS has its packages."""
    return os.environ.get(AMENT, ""), os.environ.get(ROS, "")


class PackageFinder:
    """Finds files of packages for one file that names them.

    Args:
        beside: that file.
    """

    def __init__(self, beside: Path) -> None:
        self._above = list(beside.parents)

    def find(self, name: str) -> Path | None:
        """The file of `package://NAME/..`, links followed; None where there is none."""
        return next((path.resolve() for path in self._candidates(name) if path.is_file()), None)

    def find_above(self, name: str) -> Path | None:
        """The same in the folders above the file that names it only."""
        return next((path.resolve() for path in self._beside(name) if path.is_file()), None)

    def searched(self, name: str) -> str:
        """Which package was looked for, and where, in words."""
        package, inside = split(name)
        folder = next(self._installed(package), None)
        if folder is not None:
            return f"the package {package!r} in {folder} has no file {inside!r}"
        places = [f"the folders above, from {self._above[0]} on"] if self._above else []
        for variable, value in zip((AMENT, ROS), environment(), strict=True):
            places.append(f"{variable} ({value or 'not set'})")
        return f"looked for the package {package!r} in {', '.join(places)}"

    def _candidates(self, name: str) -> Iterator[Path]:
        package, inside = split(name)
        yield from self._beside(name)
        yield from (folder / inside for folder in self._installed(package))

    def _beside(self, name: str) -> Iterator[Path]:
        package, inside = split(name)
        for folder in self._above:
            if (folder / INDEX).is_file() and name in (copies := _index(folder)):
                yield folder / copies[name]
            if folder.name == package:
                yield folder / inside
            yield folder / package / inside
            # A package's folder may have another name than the package.
            if (folder / MANIFEST).is_file() and package_name(folder) in (package, None):
                yield folder / inside

    def _installed(self, package: str) -> Iterator[Path]:
        for prefix in _folders(AMENT):
            if (prefix / "share" / package).is_dir():
                yield prefix / "share" / package
        if package in self._sources:
            yield self._sources[package]

    @cached_property
    def _sources(self) -> dict[str, Path]:
        """Packages below the folders of ROS_PACKAGE_PATH by name; of several of a name the first, as in ROS."""
        found: dict[str, Path] = {}
        for folder in _folders(ROS):
            for package in _packages_below(folder):
                found.setdefault(package_name(package) or package.name, package)
        return found


def split(name: str) -> tuple[str, str]:
    """Package, and path within it, of `package://NAME/PATH`."""
    package, _, inside = name.partition("://")[2].partition("/")
    return package, inside


def package_name(folder: Path) -> str | None:
    """The name that a folder's package.xml gives; None where it gives none."""
    try:
        with (folder / MANIFEST).open("rb") as file:
            found = _NAME.search(file.read(MAX_MANIFEST_BYTES))
    except OSError:
        return None
    return None if found is None else found.group(1).decode("utf-8", errors="replace")


def write_index(folder: Path, files: Mapping[str, str]) -> None:
    """Say in a folder of copies where those of packages are: paths below it by the names `package://NAME/..`."""
    (folder / INDEX).write_text(json.dumps(dict(sorted(files.items())), indent=1) + "\n", encoding="utf-8")


def _index(folder: Path) -> dict[str, str]:
    try:
        with (folder / INDEX).open("rb") as file:
            found = json.loads(file.read(MAX_INDEX_BYTES))
    except (OSError, ValueError, RecursionError):
        return {}
    if not isinstance(found, dict):
        return {}
    return {name: path for name, path in found.items() if isinstance(path, str) and "\0" not in path}


def _folders(variable: str) -> list[Path]:
    return [Path(text) for text in os.environ.get(variable, "").split(os.pathsep) if text]


def _packages_below(root: Path) -> Iterator[Path]:
    """Folders with a package.xml, those nearer to the root first; bounded, links followed once."""
    waiting, seen, looked_at = [root], set(), 0
    while waiting and looked_at < MAX_FOLDERS:
        folder = waiting.pop(0)
        looked_at += 1
        try:
            real = folder.resolve()
            names = sorted(path.name for path in folder.iterdir())
        except (OSError, RuntimeError):
            continue
        if real in seen or any(name in names for name in IGNORED):
            continue
        seen.add(real)
        if MANIFEST in names:
            yield folder
        waiting += [folder / name for name in names if not name.startswith(".") and (folder / name).is_dir()]
