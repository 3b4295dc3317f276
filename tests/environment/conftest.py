"""Scenario files for environments."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

Content = dict[str, Any]


@pytest.fixture
def write(tmp_path: Path) -> Callable[[Content], Path]:
    """Writes a scenario file and gives its path."""

    def write_scenario(content: Content) -> Path:
        path = tmp_path / "family.yaml"
        path.write_text(json.dumps({"version": 1, **content}), encoding="utf-8")
        return path

    return write_scenario
