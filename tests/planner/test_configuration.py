"""Planner files: which parameters hold for which robot, and every error by its text."""

# ruff: noqa: E501 - tables of one case a line

import importlib
import json
import math
import os
import pickle
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from pytest_lpb.errors import ConfigurationError
from pytest_lpb.isolation.far.description import described
from pytest_lpb.planner.configuration import PlannerConfiguration
from pytest_lpb.planner.files import find_planners, read_planner
from pytest_lpb.planner.pd import PD

ROBOTS = """\
planner: pd
parameters: {p: 1.0, k: 1.0}
per_robot:
  point: {p: 2.0}
  "@velocity": {p: 3.0, k: 3.0}
  point@velocity: {k: 4.0}
"""

HEAD = """from dataclasses import dataclass
import numpy as np
from pytest_lpb import Planner
class Mine(Planner):
"""


@pytest.fixture(autouse=True)
def working_directory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("planners").mkdir()


def write(text: str, name: str = "mine") -> None:
    Path(f"planners/{name}.yaml").write_text(text)


def fault(text: str) -> str:
    """What is wrong with planners/mine.yaml of this content."""
    write(text)
    with pytest.raises(ConfigurationError) as caught:
        find_planners(["mine"], [Path("planners")])
    return str(caught.value)


@pytest.mark.parametrize(
    ("robot", "control", "p", "k"),
    [
        ("planar_arm_3", "acceleration", 1.0, 1.0),
        ("point", "acceleration", 2.0, 1.0),
        ("planar_arm_3", "velocity", 3.0, 3.0),
        ("point", "velocity", 2.0, 4.0),
    ],
)
def test_the_most_specific_entry_wins_key_by_key(robot: str, control: str, p: float, k: float) -> None:
    write(ROBOTS)
    parameters = read_planner(Path("planners/mine.yaml"), "mine").parameters_for(robot, control)
    assert parameters == PD.Parameters(p=p, k=k)


def test_a_configuration_survives_pickling() -> None:
    write(ROBOTS)
    configuration = read_planner(Path("planners/mine.yaml"), "mine")
    again = pickle.loads(pickle.dumps(configuration))
    assert again.parameters_for("point", "velocity") == configuration.parameters_for("point", "velocity")
    assert again.parameters_hash == configuration.parameters_hash


def test_the_hash_speaks_of_what_the_planner_does_not_of_its_file() -> None:
    write(ROBOTS)
    write("# the same\ndescription: Mine.\n" + ROBOTS, "other")
    write(ROBOTS.replace("k: 4.0", "k: 4.5"), "third")
    hashes = [read_planner(Path(f"planners/{name}.yaml"), name).parameters_hash for name in ("mine", "other", "third")]
    assert hashes[0] == hashes[1] != hashes[2]


def test_names_are_found_in_folders_then_shipped_then_registered() -> None:
    write("planner: pd\nparameters: {p: 9.0}\n", "pd")
    write("planner: potential_field\n", "mine")
    found = find_planners(["pd", "potential_field", "mine", "again=planners/mine.yaml"], [Path("planners")])
    assert [c.name for c in found] == ["pd", "potential_field", "mine", "again"]
    assert found[0].parameters_for("point", "acceleration").p == 9.0
    assert found[1].path is not None
    assert found[1].path.name == "potential_field.yaml"


@pytest.mark.parametrize("name", ["pd", "potential_field"])
def test_shipped_files_are_right_and_say_what_they_are(name: str) -> None:
    (configuration,) = find_planners([name], [])
    assert configuration.path is not None
    assert "description:" in configuration.path.read_text()
    for robot in ("point", "planar_arm_3", "differential_drive"):
        for control in ("acceleration", "velocity"):
            configuration.parameters_for(robot, control)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("planer: pd\n", "planners/mine.yaml:1: planer: unknown key; did you mean 'planner'?; allowed: command, deadline_s, delay, description"),
        ("planner: pd\nperiode: 0.1\n", "planners/mine.yaml:2: periode: unknown key; did you mean 'period'?; allowed: command, deadline_s, delay, description"),
        ("parameters: {}\n", "planners/mine.yaml:1: planner: missing; name the planner's class here"),
        ("planner: pd\nperiod: fast\n", "planners/mine.yaml:2: period: Input should be a valid number, found 'fast'"),
        ("planner: pd\ndelay: -0.1\n", "planners/mine.yaml:2: delay: Input should be greater than or equal to 0, found -0.1"),
        ("planner: pd\nparameters: [1]\n", "planners/mine.yaml:2: parameters: Input should be a valid dictionary, found [1]"),
        ("- pd\n", "planners/mine.yaml:1: found a list; a planner configuration is a mapping with the key `planner`"),
        ("planner: pd\nper_robot: {point@velocty: {k: 0.0}}\n", "planners/mine.yaml:2: per_robot: point@velocty: unknown control 'velocty'; did you mean 'velocity'?; allowed: acceleration, torque, velocity"),
        ("planner: pd\nparameters: {q: 1.0}\n", "planners/mine.yaml:2: parameters: q: unknown parameter; PD has damping, derivative, k, lookahead, p"),
        ("planner: pd\nparameters: {dampling: 1.0}\n", "planners/mine.yaml:2: parameters: dampling: unknown parameter; did you mean 'damping'?; PD has damping, derivative, k, lookahead, p"),
        ("planner: pd\nparameters: {p: high}\n", "parameters: p: Input should be a valid number, found 'high'"),
        ("planner: pd\nparameters: {p: true}\n", "parameters: p: Input should be a valid number, found True"),
        ("planner: pd\nparameters: {derivative: exact}\n", "parameters: derivative: Input should be 'velocity' or 'difference', found 'exact'"),
        ("planner: pd\nper_robot: {point: {kp: 1.0}}\n", "planners/mine.yaml:2: per_robot: point: kp: unknown parameter; did you mean 'p' or 'k'?; PD has damping, derivative, k, lookahead, p"),
        ("planner: potential_field\nparameters: {spacing: 0}\n", "parameters: spacing: Input should be greater than 0, found 0"),
        ("planner: potential_feild\n", "unknown planner 'potential_feild'; did you mean 'potential_field'?"),
        ("planner: pd\nparameters: {p: .inf}\n", "planners/mine.yaml:2: parameters: p: found inf; a finite number is required"),
        ("planner: pd\nper_robot: {point: {p: .nan}}\n", "planners/mine.yaml:2: per_robot: point: p: found nan; a finite number is required"),
        ("planner: ':Mine'\n", "planner ':Mine': write it as module:Class"),
        ("planner: '.mine:Mine'\n", "planner '.mine:Mine': write it as module:Class"),
        ("planner: no.such.module:Mine\n", "planner 'no.such.module:Mine': cannot import 'no.such.module'"),
    ],
)  # fmt: skip
def test_faults_of_a_file(text: str, message: str) -> None:
    assert message in fault(text)


@pytest.mark.parametrize(
    ("key", "value", "dt", "message"),
    [
        ("period", 0.12, 0.05, "planners/mine.yaml:2: period: 0.12 s is no multiple of this scenario's dt = 0.05 s; use 0.1"),
        ("period", 0.01, 0.05, "planners/mine.yaml:2: period: 0.01 s is no multiple of this scenario's dt = 0.05 s; use 0.05"),
        ("delay", 0.03, 0.02, "planners/mine.yaml:2: delay: 0.03 s is no multiple of this scenario's dt = 0.02 s; use 0.04"),
    ],
)  # fmt: skip
def test_times_that_are_no_multiple_of_dt(key: str, value: float, dt: float, message: str) -> None:
    write(f"planner: pd\n{key}: {value}\n")
    configuration = read_planner(Path("planners/mine.yaml"), "mine")
    with pytest.raises(ConfigurationError) as caught:
        (configuration.steps_per_call if key == "period" else configuration.steps_of_delay)(dt)
    assert str(caught.value) == message


def test_times_that_are_multiples_of_dt_but_for_rounding() -> None:
    write("planner: pd\nperiod: 0.3\ndelay: 0.15\n")
    configuration = read_planner(Path("planners/mine.yaml"), "mine")
    assert (configuration.steps_per_call(0.1), configuration.steps_of_delay(0.05)) == (3, 3)


def test_a_name_may_be_used_once() -> None:
    with pytest.raises(ConfigurationError, match=r"^planner 'pd' is named twice in pd, pd$"):
        find_planners(["pd", "pd"], [])


def test_an_unknown_planner_is_met_with_the_nearest_names() -> None:
    write("planner: pd\n", "my_planner")
    with pytest.raises(ConfigurationError) as caught:
        find_planners(["my_planer"], [Path("planners")])
    text = str(caught.value)
    assert text.startswith("unknown planner 'my_planer'; did you mean 'my_planner'?; known are ")
    assert "pd, potential_field" in text
    assert "(searched planners, " in text


def test_a_file_that_is_not_there() -> None:
    with pytest.raises(ConfigurationError, match=r"planner 'gone': cannot read gone.yaml: No such file or directory"):
        find_planners(["gone.yaml"], [])


@pytest.mark.parametrize(
    ("code", "message"),
    [
        ("def broken(:", "cannot import 'broken': SyntaxError: "),
        ("raise ValueError('no licence')", "cannot import 'broken': ValueError: no licence (.*broken.py:1)"),
        ("import no_such_package", "cannot import 'broken': No module named 'no_such_package' (.*broken.py:1)"),
        ("Mine = 3", "is 3, not a subclass of pytest_lpb.Planner"),
        (f"{HEAD}    class Parameters:\n        gain: float = 1.0\n", "broken:Mine: Parameters must be a dataclass"),
        (
            f"{HEAD}    @dataclass(frozen=True)\n    class Parameters:\n        gain: np.ndarray = None\n",
            "broken:Mine: Parameters has a field of a type that no YAML value fits",
        ),
    ],
)
def test_faults_of_a_module(code: str, message: str, monkeypatch: pytest.MonkeyPatch) -> None:
    Path("broken.py").write_text(code, "utf-8")
    monkeypatch.syspath_prepend(".")
    monkeypatch.delitem(sys.modules, "broken", raising=False)
    write("planner: broken:Mine\n")
    with pytest.raises(ConfigurationError) as caught:
        find_planners(["mine"], [Path("planners")])
    text = str(caught.value)
    first, _, last = message.partition(".*")
    assert first in text
    assert text.endswith(last)
    assert "\n" not in text


RICH = """from dataclasses import dataclass, field
from enum import Enum, IntEnum
from math import inf, nan
from pathlib import Path
from pytest_lpb import Planner
class Mode(Enum):
    BOLD = "bold"
    CALM = "calm"
class Level(IntEnum):
    LOW = 1
@dataclass(frozen=True)
class Inner:
    bound: float = -inf
class Rich(Planner):
    @dataclass(frozen=True)
    class Parameters:
        mode: Mode = Mode.BOLD
        modes: frozenset[Mode] = frozenset({Mode.CALM, Mode.BOLD})
        level: Level = Level.LOW
        speed: float = inf
        unset: float | None = nan
        word: str = "inf"
        bounds: tuple[float, ...] = (-inf, 0.5, inf)
        names: set[str] = field(default_factory=lambda: {"b", "a", "c"})
        by_name: dict[str, float] = field(default_factory=lambda: {"a": inf})
        file: Path = Path("model/net.onnx")
        inner: Inner = Inner()
"""
RECORDED = {
    "mode": "bold", "modes": ["bold", "calm"], "level": 1, "speed": "inf", "unset": "nan", "word": "inf",
    "bounds": ["-inf", 0.5, "inf"], "names": ["a", "b", "c"], "by_name": {"a": "inf"}, "file": "model/net.onnx",
    "inner": {"bound": "-inf"},
}  # fmt: skip


@pytest.fixture
def rich(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(tmp_path)
    Path("rich_module.py").write_text(RICH)
    write("planner: rich_module:Rich\nper_robot: {point: {speed: .inf, mode: calm, names: [z, y]}}\n")
    sys.modules.pop("rich_module", None)


def test_parameters_of_every_type_are_recorded_and_loaded_again(rich: None) -> None:
    first = read_planner(Path("planners/mine.yaml"), "mine")
    entry = json.loads(json.dumps(first.to_dict(), allow_nan=False))
    assert entry["parameters"] == RECORDED
    assert entry["per_robot"] == {"point": {"speed": "inf", "mode": "calm", "names": ["z", "y"]}}
    again = PlannerConfiguration("mine", entry["planner"], entry["parameters"], entry["per_robot"])
    again.check()
    assert shown(again.parameters_for("panda", "velocity")) == shown(first.parameters_for("panda", "velocity"))
    assert again.parameters_for("point", "velocity").speed == math.inf
    assert again.parameters_hash == first.parameters_hash == parameters_hash_of_another_process()


def shown(parameters: Any) -> dict[str, Any]:
    """Parameters as text: NaN is not equal to itself, and equal sets may be in another order."""
    return {
        name: sorted(map(repr, value)) if isinstance(value, set | frozenset) else repr(value)
        for name, value in vars(parameters).items()
    }


def parameters_hash_of_another_process() -> str:
    """As another process computes it, in which sets have another order."""
    code = "from pathlib import Path; from pytest_lpb.planner.files import read_planner; "
    code += "print(read_planner(Path('planners/mine.yaml'), 'mine').parameters_hash)"
    environment = {**os.environ, "PYTHONHASHSEED": "7"}
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    return done.stdout.strip()


@pytest.mark.parametrize("pydantic", [True, False])
def test_the_far_side_reads_them_as_well(rich: None, pydantic: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    if not pydantic:
        monkeypatch.setitem(sys.modules, "pydantic", None)
    cls = importlib.import_module("rich_module").Rich
    told = described(cls, [{}, {"mode": "calm", "speed": "inf", "bounds": [1.0, "nan"], "names": ["x"]}])["sets"]
    assert told[0]["parameters"] == RECORDED
    assert told[1]["parameters"] == {**RECORDED, "mode": "calm", "bounds": [1.0, "nan"], "names": ["x"]}
    if not pydantic:
        assert described(cls, [{"mode": "odd"}])["sets"] == [{"fault": "mode: found 'odd'; allowed are 'bold', 'calm'"}]


def test_text_is_no_number_where_a_class_wants_whole_ones() -> None:
    assert "found 'infinite'" in fault("planner: pd\nparameters: {p: infinite}\n")
    assert "found inf; a finite number is required" in fault("planner: pd\nparameters: {p: inf}\n")
    assert "a finite number is required" in fault("command: [cat]\nparameters: {p: .inf}\n")
