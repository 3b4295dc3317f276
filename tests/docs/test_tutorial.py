"""docs/tutorial.md, file by file and command by command."""

from __future__ import annotations

import os
import re
import shlex

import pytest

from pytest_lpb.cli import main
from tests.docs.test_examples import BLOCK, ROOT
from tests.plugin.projects import FAST, Project, text_of

COMMAND = re.compile(r"^(\S+)(.*?) +# ends with (\d)$", re.MULTILINE)


def test_from_an_empty_folder_to_a_gate(project: Project, monkeypatch: pytest.MonkeyPatch) -> None:
    for key in [key for key in os.environ if key.startswith(("PYTEST_", "COV_"))]:
        monkeypatch.delenv(key)
    printed = []
    for language, text in BLOCK.findall((ROOT / "docs/tutorial.md").read_text("utf-8")):
        if language != "sh":
            path, _, content = text.removeprefix("# ").partition("\n")
            project.write(path, content)
            continue
        for program, words, code in COMMAND.findall(text):
            arguments = shlex.split(words)
            if program == "pytest":
                result = project.run(FAST, *arguments, planners=None)
                printed.append(text_of(result))
                assert result.ret == int(code), printed[-1]
            else:
                assert main(arguments) == int(code), (program, words)
    first, second, gated = printed
    assert "hit obstacle 'drawn" in first
    assert "regressed" in gated
    assert "regressed" not in second
    assert (project.path / "reports/latest/report.html").is_file()
