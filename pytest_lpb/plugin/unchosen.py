"""Says how to choose planners when a scenario file is named without any."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

_KEYS = (re.compile(r"^robot\s*:", re.MULTILINE), re.compile(r"^goal\s*:", re.MULTILINE))
_MAX_CHARACTERS = 1 << 20


def explain_unchosen_planners(config: pytest.Config) -> None:
    """Raise UsageError for the first argument that is a scenario file; other YAML files are other plugins' business."""
    for argument in config.args:
        path = Path(config.invocation_params.dir, argument.partition("::")[0])
        if path.suffix in (".yaml", ".yml") and path.is_file():
            text = path.read_bytes()[:_MAX_CHARACTERS].decode(errors="replace")
            if all(key.search(text) for key in _KEYS):
                raise pytest.UsageError(
                    f"{argument} is a scenario of pytest-lpb; choose planners to run it with: "
                    f"pytest --lpb-planners=pd,potential_field {argument}"
                )
