"""Scenario files for environments; hypothesis without deadlines, since machines that run tests are shared."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings

settings.register_profile("no_deadline", deadline=None)
settings.load_profile("no_deadline")

Content = dict[str, Any]


@pytest.fixture
def write(tmp_path: Path) -> Callable[[Content], Path]:
    """Writes a scenario file and gives its path."""

    def write_scenario(content: Content) -> Path:
        path = tmp_path / "family.yaml"
        path.write_text(json.dumps({"version": 1, **content}), encoding="utf-8")
        return path

    return write_scenario
