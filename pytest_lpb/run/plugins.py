"""KPIs and plots of users: entry points, modules named in ini files, conftest files; loaded again by `lpb-report`."""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Iterable, Mapping
from importlib import import_module
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any

from pytest_lpb.errors import KpiError
from pytest_lpb.kpis.registry import default_registry

ENTRY_POINT_GROUP = "pytest_lpb.kpis"
OWN_PACKAGE = "pytest_lpb"


def load_kpi_entry_points() -> None:
    """Import what installed packages offer. Raises KpiError when one cannot be imported."""
    for point in entry_points(group=ENTRY_POINT_GROUP):
        try:
            point.load()
        except (ImportError, AttributeError) as error:
            raise KpiError(f"entry point {point.name!r} of {ENTRY_POINT_GROUP}: {error}") from error


def user_modules(also: Iterable[str] = ()) -> list[dict[str, str]]:
    """Modules of users that registered KPIs, and `also`; each with its file, to load it again elsewhere."""
    names = dict.fromkeys([*also, *(kpi.module for kpi in default_registry)])
    return [
        {"module": name, "file": str(getattr(sys.modules.get(name), "__file__", "") or "")}
        for name in names
        if name.partition(".")[0] != OWN_PACKAGE
    ]


def load_user_modules(recorded: Iterable[Mapping[str, Any]]) -> list[str]:
    """Load the modules that a run recorded; warnings for those that are gone."""
    warnings = []
    for entry in recorded:
        name, file = entry["module"], entry["file"]
        if name in sys.modules:
            continue
        if Path(file).is_file():
            load_file(Path(file), name)
        else:
            try:
                import_module(name)
            except ImportError as error:
                warnings.append(f"KPIs of module {name!r} are left out: {error}; name it with --plugin")
    return warnings


def load_plugin(reference: str) -> None:
    """Import a module by its name, or by the path of its file. Raises KpiError when that fails."""
    if reference.endswith(".py"):
        load_file(Path(reference), Path(reference).stem)
        return
    try:
        import_module(reference)
    except ImportError as error:
        raise KpiError(f"--plugin: cannot import {reference!r}: {error}") from error


def load_file(path: Path, name: str) -> None:
    """Import a Python file as a module. Raises KpiError when it cannot be read."""
    specification = importlib.util.spec_from_file_location(name, path)
    if specification is None or specification.loader is None or not path.is_file():
        raise KpiError(f"cannot load KPIs from {path}: it is no Python file")
    module = importlib.util.module_from_spec(specification)
    sys.modules[name] = module
    specification.loader.exec_module(module)
