"""Which files are scenarios: `lpb_scenarios`, files named on the command line, folders that are never walked."""

from __future__ import annotations

from pathlib import Path

import pytest

from pytest_lpb.plugin.collection import glob_pattern
from pytest_lpb.plugin.scenarios import RESERVED_KEY
from pytest_lpb.run.summary import ALL

from .projects import SCENARIO, UNSOLVED, Project, hashes_of, node_ids, read_run, text_of


def listed(project: Project, *arguments: str | Path, planners: str | None = "pd") -> list[str]:
    return node_ids(project.run("--collect-only", "-q", *arguments, planners=planners))


@pytest.mark.parametrize(
    ("glob", "path", "matches"),
    [
        ("scenarios/**/*.yaml", "scenarios/x.yaml", True),
        ("scenarios/**/*.yaml", "scenarios/a/b/x.yaml", True),
        ("scenarios/**/*.yaml", "scenarios/x.yml", False),
        ("scenarios/**/*.yaml", "old_scenarios/x.yaml", False),
        ("scenarios/**/*.yaml", "scenariosXx.yaml", False),
        ("**/scenarios/**/*.yaml", "a/scenarios/x.yaml", True),
        ("**/scenarios/**/*.yaml", "scenarios/x.yaml", True),
        ("*.yaml", "a/x.yaml", False),
        ("bench_?.y*ml", "bench_1.yml", True),
        ("a+b/*.yaml", "a+b/x.yaml", True),
        ("a+b/*.yaml", "aab/x.yaml", False),
    ],
)
def test_globs(glob: str, path: str, *, matches: bool) -> None:
    assert bool(glob_pattern(glob).fullmatch(path)) == matches


def test_bare_pytest_in_a_planner_repository_collects_scenarios_only(project: Project) -> None:
    project.ini("lpb_planners = pd")
    project.scenario()
    project.scenario("robots/cart/scenarios/deep/y.yaml")
    project.write("planners/mine.yaml", "planner: pd\n")
    project.write("docker-compose.yml", "services: {}\n")
    project.write(".github/workflows/ci.yml", "on: push\n")
    project.write(".github/scenarios/ci.yaml", "on: push\n")
    project.write("old/scenarios/.hidden/z.yaml", "robot: none\n")
    project.run(planners=None).assert_outcomes(passed=2)
    expected = ["robots/cart/scenarios/deep/y.yaml::pd::seed0", "scenarios/point/x.yaml::pd::seed0"]
    assert listed(project, planners=None) == expected
    # Once more, beside the run folder that the first run left.
    project.run(planners=None).assert_outcomes(passed=2)
    assert len(project.runs()) == 2
    assert [row["scenario"] for row in project.rows()] == ["point/x", "robots/cart/scenarios/deep/y"]


def test_ini_globs_replace_the_default(project: Project) -> None:
    project.ini("lpb_scenarios =", "    worlds/*.yml", "    more/**/s_*.yaml")
    project.scenario()
    project.scenario("worlds/a.yml")
    project.scenario("worlds/deep/b.yml")
    project.scenario("more/x/s_1.yaml")
    assert listed(project) == ["more/x/s_1.yaml::pd::seed0", "worlds/a.yml::pd::seed0"]


def test_a_matching_file_that_is_no_scenario_is_an_error(project: Project) -> None:
    project.scenario()
    project.write("scenarios/settings.yaml", "color: blue\n")
    result = project.run()
    assert result.ret == 2
    assert "scenarios/settings.yaml:1: color: unknown key" in text_of(result)
    assert project.runs() == []


@pytest.mark.parametrize("reports", ["reports", "results/of trials", "../elsewhere"])
def test_run_folders_are_never_walked(project: Project, reports: str) -> None:
    # The scenario's key has a folder `scenarios`, so files in its run folder match the globs.
    project.ini()
    project.scenario("sub/scenarios/x.yaml")
    project.run(f"--lpb-reports={reports}").assert_outcomes(passed=1)
    (run,) = project.runs(reports)
    concrete = run / "trials/sub/scenarios/x/pd/seed0.yaml"
    assert concrete.is_file()
    assert listed(project, f"--lpb-reports={reports}") == ["sub/scenarios/x.yaml::pd::seed0"]
    # Nor when another folder takes reports now, nor when pytest is told to walk it.
    assert listed(project) == ["sub/scenarios/x.yaml::pd::seed0"]
    if not reports.startswith(".."):
        for folder in (run, run / "trials", run.parent):
            assert listed(project, folder) == []


def test_a_run_in_the_current_folder_finds_no_problems_of_earlier_runs(project: Project) -> None:
    project.scenario()
    for _ in range(3):
        project.run("--lpb-reports=.").assert_outcomes(passed=1)
    assert len(project.runs(".")) == 3


def test_a_concrete_problem_named_in_a_run_folder_repeats_its_trial(project: Project) -> None:
    project.scenario()
    project.run("--lpb-seed=3").assert_outcomes(passed=1)
    (run,) = project.runs()
    concrete = run / "trials/point/x/pd/seed3.yaml"
    project.run(concrete.relative_to(project.path)).assert_outcomes(passed=1)
    row = project.row()
    assert row["seed"] == "3"
    assert row["scenario"] == f"reports/{run.name}/trials/point/x/pd/seed3"
    assert row["trajectory_hash"] == hashes_of(run)["point/x", "pd", "3"]


@pytest.mark.parametrize("path", [".hidden/x.yaml", "notes/x.yaml", "planners/x.yml", "build/x.yaml"])
def test_a_named_file_is_collected_wherever_it_lies(project: Project, path: str) -> None:
    project.scenario(path)
    project.scenario(str(Path(path).with_name("sibling.yaml")))
    assert listed(project, path) == [f"{path}::pd::seed0"]
    assert listed(project, f"./{Path(path).parent}/../{path}") == [f"{path}::pd::seed0"]


def test_a_file_behind_a_link_is_collected(project: Project) -> None:
    project.scenario("store/real/x.yaml")
    (project.path / "linked").symlink_to("store/real", target_is_directory=True)
    assert listed(project, "linked/x.yaml") == ["linked/x.yaml::pd::seed0"]
    # pytest takes `..` out of a path without looking at links.
    project.scenario("store/y.yaml", UNSOLVED)
    project.scenario("y.yaml")
    assert listed(project, "linked/../y.yaml") == ["y.yaml::pd::seed0"]


def test_spaces_in_folders(project: Project) -> None:
    project.scenario("my scenarios/scenarios/two words/x.yaml")
    project.run("my scenarios").assert_outcomes(passed=1)
    assert project.row()["scenario"] == "my scenarios/scenarios/two words/x"
    assert list((project.runs()[-1] / "trials").rglob("seed0.parquet"))


@pytest.mark.parametrize("name", ["two words", "x,y", "größe", "a" * 101, "x::y", "-*-"])
def test_names_of_files_that_no_key_may_have(project: Project, name: str) -> None:
    project.scenario(f"scenarios/{name}.yaml")
    result = project.run("scenarios")
    assert result.ret == 2
    assert f"{name}.yaml: the file's name may have letters, digits, _ . - only; rename it" in text_of(result)
    assert project.runs() == []


def test_the_key_of_summary_rows_is_reserved(project: Project) -> None:
    assert RESERVED_KEY == ALL
    project.scenario("scenarios/all.yaml")
    result = project.run("scenarios")
    assert result.ret == 2
    assert "all.yaml: 'all' stands for all scenarios in tables; rename the file" in text_of(result)
    project.scenario("scenarios/point/all.yaml")
    project.run("scenarios/point").assert_outcomes(passed=1)


@pytest.mark.parametrize("other", ["x.yaml", "scenarios/x.yml"])
def test_two_files_with_one_key_are_an_error(project: Project, other: str) -> None:
    project.scenario("scenarios/x.yaml")
    project.scenario(other, UNSOLVED)
    result = project.run("scenarios/x.yaml", other)
    assert result.ret == 2
    assert "scenario 'x' is also the name of" in text_of(result)
    assert project.runs() == []


@pytest.fixture
def elsewhere(project: Project) -> Path:
    """A folder outside of the project."""
    folder = project.path.parent / f"{project.path.name}_elsewhere"
    folder.mkdir()
    return folder


def test_a_file_outside_of_the_rootdir(project: Project, elsewhere: Path) -> None:
    project.ini()
    project.scenario()
    outside = elsewhere / "far.yaml"
    outside.write_text(UNSOLVED)
    result = project.run("--rootdir", project.path, outside, "scenarios")
    result.assert_outcomes(passed=1, failed=1)
    keys = [row["scenario"] for row in project.rows()]
    assert keys[1] == "point/x"
    stem, _, digest = keys[0].rpartition("-")
    assert stem == "far"
    assert len(digest) == 8
    run = project.runs()[-1]
    assert read_run(run)["scenarios"][keys[0]]["file"] == str(outside)
    # The command that repeats the trial finds the file again.
    command = next(line for line in result.stdout.lines if line.startswith("repeat: "))
    again = project.pytester.runpytest_inprocess(*command.split()[2:])
    again.assert_outcomes(failed=1)
    assert project.row()["trajectory_hash"] == hashes_of(run)[keys[0], "pd", "0"]


def test_equal_names_outside_of_the_rootdir_are_told_apart(project: Project, elsewhere: Path) -> None:
    project.ini()
    files = []
    for folder in ("a", "b"):
        (elsewhere / folder).mkdir()
        files.append(elsewhere / folder / "x.yaml")
        files[-1].write_text(SCENARIO)
    project.run("--rootdir", project.path, *files).assert_outcomes(passed=2)
    assert len({row["scenario"] for row in project.rows()}) == 2


@pytest.mark.parametrize(
    ("where", "argument"),
    [
        (".", "scenarios"),
        ("scenarios", "."),
        ("other", "../scenarios"),
        (".", "scenarios/point"),
        ("scenarios", None),
    ],
)
def test_scenario_folders_without_an_ini_file(
    project: Project, monkeypatch: pytest.MonkeyPatch, where: str, argument: str | None
) -> None:
    project.scenario()
    (project.path / where).mkdir(exist_ok=True)
    monkeypatch.chdir(project.path / where)
    arguments = [] if argument is None else [argument]
    assert [line.rpartition("/")[2] for line in listed(project, *arguments)] == ["x.yaml::pd::seed0"]


def test_a_folder_elsewhere_without_an_ini_file(project: Project, elsewhere: Path) -> None:
    (elsewhere / "scenarios").mkdir()
    (elsewhere / "scenarios/x.yaml").write_text(SCENARIO)
    project.run(elsewhere / "scenarios").assert_outcomes(passed=1)
    # The reports go to where pytest was called.
    assert len(project.runs()) == 1
    assert project.row()["scenario"].endswith("x")
