"""Sources that are sent to an interpreter: the far side's, and those of ours that planners use."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from importlib.resources import files
from pathlib import Path

PACKAGE = "pytest_lpb"
FAR = ("isolation/__init__.py", "isolation/far")
# NumPy is all that these import when a robot in the plane, or one in space by its URDF, is built.
OURS: tuple[str, ...] = (
    *("errors.py", "names.py", "bounded.py", "motion", "problem", "trial/__init__.py", "trial/read_only.py"),
    *(f"planner/{name}.py" for name in ("__init__", "base", "registry", "read_only")),
)


@cache
def far_sources() -> dict[str, str]:
    """The far side by module name; a package's name ends with a dot."""
    return {**_read(FAR), f"{PACKAGE}.": ""}


@cache
def our_sources() -> dict[str, str]:
    """What `from pytest_lpb import Planner` and a problem with its robot need."""
    return _read(("__init__.py", *OURS))


@cache
def boot_source() -> str:
    """What is executed first."""
    return (_root() / "isolation" / "far" / "boot.py").read_text("utf-8")


def _root() -> Path:
    return Path(str(files(PACKAGE)))


def _read(names: Iterable[str]) -> dict[str, str]:
    root = _root()
    paths = [root / name for name in names if name.endswith(".py")]
    paths += [path for name in names if not name.endswith(".py") for path in sorted((root / name).rglob("*.py"))]
    return {_module(path.relative_to(root)): path.read_text("utf-8") for path in paths}


def _module(path: Path) -> str:
    parts = (PACKAGE, *path.with_suffix("").parts)
    return ".".join(parts[:-1]) + "." if parts[-1] == "__init__" else ".".join(parts)
