"""Imports modules whose sources came with a message, where they are not installed."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from importlib.util import spec_from_loader
from types import ModuleType
from typing import Any


class ShippedModules(MetaPathFinder, Loader):
    """Finds modules in a mapping of names to sources; a package's name ends with a dot."""

    def __init__(self, sources: Mapping[str, str]) -> None:
        self._sources = dict(sources)

    def find_spec(self, name: str, path: Any = None, target: Any = None) -> ModuleSpec | None:  # noqa: ARG002
        """The module's spec, if it came along."""
        if name + "." in self._sources:
            return spec_from_loader(name, self, is_package=True)
        return spec_from_loader(name, self) if name in self._sources else None

    def exec_module(self, module: ModuleType) -> None:
        """Run the module's source."""
        name = module.__name__
        source = self._sources.get(name + ".", self._sources.get(name, ""))
        # The file is none of this machine's: messages about a planner's faults leave it out.
        exec(compile(source, "<" + name + ">", "exec"), module.__dict__)


def install(sources: Mapping[str, str]) -> None:
    """Make the modules importable, before any that are installed."""
    sys.meta_path.insert(0, ShippedModules(sources))


def forget(package: str) -> None:
    """Undo `install` for a package, and all that was imported of it."""
    # Not by its class: the first finder was made by another copy of this source.
    sys.meta_path[:] = [finder for finder in sys.meta_path if package + "." not in getattr(finder, "_sources", ())]
    for name in [name for name in sys.modules if name == package or name.startswith(package + ".")]:
        del sys.modules[name]
