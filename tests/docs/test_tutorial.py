"""docs/tutorial.md, file by file and command by command."""

from __future__ import annotations

import os
import re
import sys
from pathlib import Path

import pytest

from tests.docs.test_examples import BLOCK, ROOT

COMMAND = re.compile(r"^(.*?) +# ends with (\d)$", re.MULTILINE)


def test_from_an_empty_folder_to_a_gate(pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> None:
    for key in [key for key in os.environ if key.startswith(("PYTEST_", "COV_"))]:
        monkeypatch.delenv(key)
    monkeypatch.setenv("PATH", str(Path(sys.executable).parent), prepend=os.pathsep)
    # As everywhere in these tests: evaluating and drawing all KPIs takes most of a small run's time.
    monkeypatch.setenv("PYTEST_ADDOPTS", "--lpb-kpis=time_to_goal_s -p no:cacheprovider")
    printed = []
    for language, text in BLOCK.findall((ROOT / "docs/tutorial.md").read_text("utf-8")):
        if language == "sh":
            for command, code in COMMAND.findall(text):
                result = pytester.run("sh", "-c", command)
                assert result.ret == int(code), command
                printed.append(result.stdout.str())
        else:
            path, _, content = text.removeprefix("# ").partition("\n")
            file = pytester.path / path
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(content, "utf-8")
    assert "hit obstacle 'drawn" in printed[0]
    assert len(printed) == 4
    assert "regressed" in printed[3]
    assert (pytester.path / "reports/latest/report.html").is_file()
