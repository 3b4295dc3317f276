"""Which files are studies. Imports nothing heavy: it is asked in every run of pytest that names a YAML file."""

from __future__ import annotations

import re
from pathlib import Path

SUFFIXES = (".yaml", ".yml")
MAX_BYTES = 1 << 20
_KEY = re.compile(rb"^study\s*:", re.MULTILINE)


def is_study(path: Path) -> bool:
    """Whether a file is a study: it has `study:` at its top level. A file that cannot be read is none."""
    if path.suffix not in SUFFIXES:
        return False
    try:
        with path.open("rb") as file:
            return _KEY.search(file.read(MAX_BYTES)) is not None
    except OSError:
        return False
