"""Without planners the plugin is inert, in whatever company pytest runs."""

from __future__ import annotations

import subprocess
import sys

import pytest

from .projects import SCENARIO, Project, text_of

# A test of somebody else's project, which must not notice that pytest-lpb is installed.
TRIVIAL = """
import sys

HEAVY = {"numpy", "scipy", "pandas", "pyarrow", "matplotlib", "gymnasium", "pydantic", "yaml", "jinja2", "casadi",
         "pybullet", "threadpoolctl"}

def test_nothing_heavy_is_imported():
    assert not HEAVY & {name.partition(".")[0] for name in sys.modules}

def test_the_plugin_is_there(pytestconfig):
    assert pytestconfig.pluginmanager.hasplugin("lpb")
    assert not pytestconfig.pluginmanager.hasplugin("lpb-collection")
"""


@pytest.fixture
def stranger(project: Project) -> Project:
    project.write("test_trivial.py", TRIVIAL)
    project.scenario()
    return project


@pytest.mark.parametrize(
    "arguments",
    [
        (),
        ("-n", "2"),
        ("-p", "no:xdist"),
        ("-p", "no:benchmark"),
        ("-p", "no:cacheprovider"),
        ("-p", "no:terminal"),
        ("-W", "error"),
        ("-o", "strict=true"),
        ("--strict-config", "--strict-markers"),
    ],
    ids=" ".join,
)
def test_a_project_without_planners_notices_nothing(stranger: Project, arguments: tuple[str, ...]) -> None:
    result = stranger.pytester.runpytest_subprocess("-p", "no:hypothesispytest", *arguments)
    assert result.ret == 0, text_of(result)
    if "no:terminal" not in arguments:
        result.assert_outcomes(passed=2)
        assert "yaml" not in text_of(result)
    assert not (stranger.path / "reports").exists()


def test_no_yaml_is_collected(stranger: Project) -> None:
    result = stranger.run("--collect-only", "-q", "scenarios", planners=None)
    assert result.ret == 5
    assert "yaml" not in text_of(result)


def test_an_empty_choice_of_planners_is_none(stranger: Project) -> None:
    stranger.ini("lpb_planners = pd")
    result = stranger.run("--lpb-planners=", "scenarios", planners=None)
    assert result.ret == 5


@pytest.mark.parametrize("argument", ["scenarios/point/x.yaml", "scenarios/point/x.yaml::pd::seed0"])
def test_a_scenario_named_without_planners_says_how_to_choose_them(stranger: Project, argument: str) -> None:
    result = stranger.run(argument, planners=None)
    assert result.ret == 4
    (line,) = [line for line in text_of(result).splitlines() if "--lpb-planners" in line]
    assert line.endswith(f"pytest --lpb-planners=pd,potential_field {argument}")
    assert f"{argument} is a scenario of pytest-lpb; choose planners" in line
    assert "Traceback" not in text_of(result)


def test_yaml_files_of_other_plugins_are_theirs(project: Project) -> None:
    project.write(
        "conftest.py",
        """
import pytest

class Spec(pytest.File):
    def collect(self):
        yield Check.from_parent(self, name="check")

class Check(pytest.Item):
    def runtest(self):
        pass

def pytest_collect_file(file_path, parent):
    if file_path.name == "spec.yaml":
        return Spec.from_parent(parent, path=file_path)
""",
    )
    project.write("spec.yaml", "robot: none\n")
    project.write("other/spec.yaml", "a: 1\n")
    project.run("spec.yaml", planners=None).assert_outcomes(passed=1)
    # With planners chosen, those below a folder are still theirs alone.
    result = project.run("other", planners="pd")
    result.assert_outcomes(passed=1)
    assert project.runs() == []


def test_python_tests_run_beside_trials(project: Project) -> None:
    project.scenario()
    project.write("test_more.py", "def test_more(): pass\n")
    project.run().assert_outcomes(passed=2)
    assert len(project.rows()) == 1


def test_no_folder_without_trials(project: Project) -> None:
    project.write("test_more.py", "def test_more(): pass\n")
    project.run().assert_outcomes(passed=1)
    assert not (project.path / "reports").exists()


def test_options_are_listed_with_their_meaning(project: Project) -> None:
    text = text_of(project.run("--help", planners=None))
    for option in ("planners", "trials", "seed", "random-start", "assert", "kpis", "reports", "render"):
        assert f"--lpb-{option}" in text
    for name in ("lpb_planners", "lpb_scenarios", "lpb_reports", "lpb_plugins", "lpb_planners_dir"):
        assert f"{name} (" in text


def test_cost_of_the_import(capsys: pytest.CaptureFixture[str]) -> None:
    script = (
        "import pytest, sys, time; before = set(sys.modules); start = time.process_time(); import pytest_lpb.plugin;"
        "print(time.process_time() - start, *sorted(set(sys.modules) - before))"
    )
    output = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True).stdout
    seconds, *modules = output.split()
    with capsys.disabled():
        print(f"\nimport of pytest_lpb.plugin: {1000 * float(seconds):.1f} ms of CPU time")
    assert modules == ["pytest_lpb", "pytest_lpb.plugin", "pytest_lpb.plugin.options"]


def test_import_of_the_package_is_lazy() -> None:
    script = "import sys, pytest_lpb; print('numpy' in sys.modules); pytest_lpb.Planner; print('numpy' in sys.modules)"
    output = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True).stdout
    assert output.split() == ["False", "True"]


def test_the_scenario_of_these_tests_is_one(project: Project) -> None:
    project.scenario(content=SCENARIO)
    assert project.run("-W", "error", "scenarios").ret == 0
    assert project.row()["outcome"] == "success"


def test_a_folder_with_nothing_but_studies_says_how_to_run_them(project: Project) -> None:
    project.write("studies/gains.yaml", "study: gains\nplanners: [pd]\nscenarios: [../scenarios/point/x.yaml]\n")
    project.write("studies/.hidden/other.yaml", "study: other\n")
    told = "lpb: no scenario to run, but a study: studies/gains.yaml; a study is run by its name: pytest studies/gains"
    for planners in (None, "pd"):
        result = project.run("studies", planners=planners)
        assert result.ret == pytest.ExitCode.NO_TESTS_COLLECTED
        assert told in text_of(result)
    # Who names no folder has not asked for them.
    assert "study" not in text_of(project.run(planners=None))
