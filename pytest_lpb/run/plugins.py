"""KPIs and plots of users: entry points, modules named in ini files, conftest files; loaded again by `lpb-report`."""

from __future__ import annotations

import hashlib
import importlib.util
import sys
from collections.abc import Callable, Iterable, Mapping
from importlib import import_module
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any

from pytest_lpb.errors import KpiError, in_one_line
from pytest_lpb.kpis.definition import innermost
from pytest_lpb.kpis.registry import default_registry
from pytest_lpb.problem.registries import origins

ENTRY_POINT_GROUP = "pytest_lpb.kpis"
OWN_PACKAGE = "pytest_lpb"


def load_kpi_entry_points() -> None:
    """Import what installed packages offer. Raises KpiError when one cannot be imported."""
    for point in entry_points(group=ENTRY_POINT_GROUP):
        try:
            point.load()
        except (ImportError, AttributeError) as error:
            raise KpiError(f"entry point {point.name!r} of {ENTRY_POINT_GROUP}: {error}") from error


def user_modules(also: Iterable[str] = (), plots: Iterable[Callable[..., Any]] = ()) -> list[dict[str, str]]:
    """Modules of users that registered KPIs, `plots`, shapes and the like, and `also`.

    Each with its file, to load it again elsewhere.
    """
    found = {(name, _file_of_module(name)): None for name in also}
    for function in (*(kpi.function for kpi in default_registry), *plots):
        origin = innermost(function)
        # Two conftest.py files are both called `conftest`: the code knows its file, sys.modules only the last one.
        code = getattr(origin, "__code__", None)
        file = str(Path(code.co_filename).resolve()) if code else _file_of_module(origin.__module__)
        found[origin.__module__, file] = None
    found |= {(origin.module, origin.file): None for origin in origins()}
    return [{"module": name, "file": file} for name, file in found if name.partition(".")[0] != OWN_PACKAGE]


def _file_of_module(name: str) -> str:
    file = getattr(sys.modules.get(name), "__file__", None)
    return str(Path(file).resolve()) if file else ""


def load_user_modules(recorded: Iterable[Mapping[str, Any]], run: Path) -> list[str]:
    """Load the modules that a run recorded; warnings for those that are gone or cannot be imported any more.

    A run folder may come from anybody: no code that lies in it is loaded, nor any by a relative path.
    """
    warnings = []
    for entry in recorded:
        name, file = entry["module"], entry["file"]
        if name in sys.modules and _file_of_module(name) == file:
            continue
        if file and (not Path(file).is_absolute() or Path(file).resolve().is_relative_to(run)):
            warnings.append(f"module {name!r} lies in the run folder, {file}, and is not loaded; name it with --plugin")
            continue
        try:
            if Path(file).is_file():
                _import_from(Path(file), name)
            else:
                import_module(name)
        except Exception as error:
            # A module may raise anything while it is imported.
            warnings.append(f"module {name!r} and its KPIs are left out: {in_one_line(error)}; name it with --plugin")
    return warnings


def _import_from(file: Path, name: str) -> None:
    """Import a module from its file; what lies beside it, or beside its package, can be imported from it."""
    if name in sys.modules:
        load_file(file, f"{name}_{hashlib.sha256(str(file).encode()).hexdigest()[:8]}")
        return
    root = str(file.parents[name.count(".") + (file.name == "__init__.py")])
    if root not in sys.path:
        sys.path.insert(0, root)
    import_module(name)


def load_plugin(reference: str) -> None:
    """Import a module by its name, or by the path of its file. Raises KpiError when that fails."""
    try:
        if reference.endswith(".py"):
            load_file(Path(reference), Path(reference).stem)
        else:
            import_module(reference)
    except KpiError:
        raise
    except Exception as error:
        # A module may raise anything while it is imported.
        raise KpiError(f"--plugin: cannot import {reference!r}: {in_one_line(error)}") from error


def load_file(path: Path, name: str) -> None:
    """Import a Python file as a module. Raises KpiError when there is none, and whatever the module raises."""
    specification = importlib.util.spec_from_file_location(name, path)
    if specification is None or specification.loader is None or not path.is_file():
        raise KpiError(f"cannot load KPIs from {path}: it is no Python file")
    module = importlib.util.module_from_spec(specification)
    sys.modules[name] = module
    try:
        specification.loader.exec_module(module)
    except BaseException:
        del sys.modules[name]
        raise
