"""`lpb-scenarios`, as users type it."""

from __future__ import annotations

from pathlib import Path

import pytest

from pytest_lpb.documents.writer import dump_yaml
from pytest_lpb.scenario.load import load_scenario
from pytest_lpb.scenarios_cli import EXIT_USAGE, main
from tests.scenario.test_importing import ARM, PANDA


@pytest.fixture
def experiment(tmp_path: Path) -> Path:
    """An experiment file of the Panda."""
    path = tmp_path / "exp.yaml"
    path.write_text(dump_yaml(PANDA), encoding="utf-8")
    return path


def test_a_scenario_is_printed(experiment: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["import", str(experiment)]) == 0
    printed = capsys.readouterr()
    path = tmp_path / "printed.yaml"
    path.write_text(printed.out, encoding="utf-8")
    assert load_scenario(path).concrete["robot"]["model"] == "panda"
    assert printed.err == "lpb-scenarios: not carried over: random obstacles of radius 0; the least is 0.001 m\n"


def test_a_scenario_is_written_once(experiment: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    output = tmp_path / "new folder" / "panda.yaml"
    assert main(["import", str(experiment), "--output", str(output)]) == 0
    assert load_scenario(output).concrete["robot"]["model"] == "panda"
    capsys.readouterr()
    assert main(["import", str(experiment), "--output", str(output)]) == EXIT_USAGE
    assert capsys.readouterr().err == f"lpb-scenarios: error: {output} is there already; choose another --output\n"


def test_a_file_that_is_not_there(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["import", str(tmp_path / "no.yaml")]) == EXIT_USAGE
    assert "no.yaml: cannot be read: No such file or directory" in capsys.readouterr().err


def test_an_experiment_that_makes_no_scenario(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "exp.yaml"
    path.write_text(dump_yaml({**ARM, "initState": {"q0": [0.0], "q0dot": [0.0]}}), encoding="utf-8")
    assert main(["import", str(path)]) == EXIT_USAGE
    assert "what it says makes no scenario: " in capsys.readouterr().err


def test_wrong_arguments_print_usage(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as caught:
        main(["export"])
    assert caught.value.code == EXIT_USAGE
    assert "usage: lpb-scenarios" in capsys.readouterr().err
