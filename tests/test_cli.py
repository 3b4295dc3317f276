"""`lpb-report`: tables, reports and plots from raw data."""

from __future__ import annotations

import json
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path

import pyarrow
import pyarrow.parquet
import pytest

from pytest_lpb.cli import main
from pytest_lpb.kpis.registry import default_registry as kpis
from pytest_lpb.planner.files import find_planners
from pytest_lpb.report.plots import default_registry as plots
from pytest_lpb.report.plots import load_builtin
from pytest_lpb.run.inputs import write_planner_files
from pytest_lpb.trial.files import METADATA_KEY

from .plugin.projects import DRAWN, UNSOLVED, Project, read_table

RESULTS = ("trials.csv", "summary.csv", "comparisons.csv", "aggregates.csv", "report.html")
State = dict[str, tuple[int, bytes]]


@pytest.fixture(autouse=True)
def forgotten() -> Iterator[None]:
    """KPIs and plots that a test registers are not the next test's."""
    load_builtin()  # before: what is registered inside is forgotten, and built-in plots register once
    with kpis.preserved(), plots.preserved():
        yield


@pytest.fixture
def run(finished_run: Path, tmp_path: Path) -> Path:
    """A copy of a finished run with two planners, two scenarios and two seeds, elsewhere than where it was made."""
    folder = tmp_path / "moved here" / finished_run.name
    shutil.copytree(finished_run, folder)
    return folder


def raw_data(run: Path) -> State:
    files = [run / "run.json", *(path for path in (run / "trials").rglob("*") if path.is_file())]
    return {str(path): (path.stat().st_mtime_ns, path.read_bytes()) for path in files}


def results(run: Path) -> dict[str, bytes]:
    return {name: (run / name).read_bytes() for name in RESULTS}


def node_ids(folder: Path) -> set[str]:
    return {row["node_id"] for row in read_table(folder / "trials.csv")}


def test_rebuilt_results_equal_the_runs_own(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before, raw = results(run), raw_data(run)
    for name in RESULTS:
        (run / name).unlink()
    assert main([str(run)]) == 0
    assert results(run) == before
    assert raw_data(run) == raw
    output = capsys.readouterr().out
    assert output.splitlines()[-1] == f"report: {run / 'report.html'}"
    assert "potential_field" in output


def test_results_of_a_run_of_pytest(project: Project) -> None:
    project.scenario("scenarios/drawn.yaml", DRAWN)
    project.scenario("scenarios/far.yaml", UNSOLVED)
    project.run("--lpb-trials=2", "scenarios", planners="pd,potential_field")
    (run,) = project.runs()
    before, raw = results(run), raw_data(run)
    for name in RESULTS:
        (run / name).unlink()
    assert main([str(run)]) == 0
    # The KPIs are those of the run: one was asked for.
    assert results(run) == before
    assert raw_data(run) == raw


def test_a_concrete_problem_repeats_its_trial_after_the_run_was_moved(
    project: Project, tmp_path_factory: pytest.TempPathFactory
) -> None:
    project.scenario(content=DRAWN)
    project.run("--lpb-trials=2", "scenarios", planners="potential_field")
    (row,) = [row for row in project.rows() if row["seed"] == "1"]
    moved = tmp_path_factory.mktemp("moved") / "run"
    project.runs()[0].rename(moved)
    project.run(moved / "trials/point/x/potential_field/seed1.yaml", planners="potential_field")
    again = project.row()
    assert again["trajectory_hash"] == row["trajectory_hash"]
    assert again["problem_hash"] == row["problem_hash"]
    assert again["seed"] == "1"


@pytest.mark.parametrize("name", ["latest", "reports/latest"])
def test_latest(project: Project, name: str, capsys: pytest.CaptureFixture[str]) -> None:
    project.scenario()
    project.run("scenarios")
    project.run("scenarios")
    capsys.readouterr()
    assert main([name]) == 0
    assert capsys.readouterr().out.splitlines()[-1] == f"report: {project.runs()[-1] / 'report.html'}"


def test_chosen_kpis(run: Path, tmp_path: Path) -> None:
    before = results(run)
    assert main([str(run), "--kpis=sparc,time_to_goal_s"]) == 0
    # A part of the run's results never takes the place of all.
    assert results(run) == before
    row = read_table(run / "selected/trials.csv")[0]
    assert list(row)[-3:] == ["time_to_goal_s", "sparc", "contended_kpis"]
    assert main([str(run), "--kpis=sparc", "--output", str(tmp_path / "out")]) == 0
    assert list(read_table(tmp_path / "out/trials.csv")[0])[-3:] == ["timing_contended", "sparc", "contended_kpis"]


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["--planners=pd"], {f"{name}.yaml::pd::seed{seed}" for name in ("drawn", "unsolved") for seed in (0, 1)}),
        (["--scenarios=drawn"], {f"drawn.yaml::{p}::seed{seed}" for p in ("pd", "potential_field") for seed in (0, 1)}),
        (["--scenarios=drawn", "--planners=pd"], {f"drawn.yaml::pd::seed{seed}" for seed in (0, 1)}),
    ],
)
def test_selected_trials(run: Path, tmp_path: Path, arguments: list[str], expected: set[str]) -> None:
    before = results(run)
    assert main([str(run), *arguments, "--output", str(tmp_path / "out")]) == 0
    assert node_ids(tmp_path / "out") == expected
    assert main([str(run), *arguments]) == 0
    assert node_ids(run / "selected") == expected
    assert results(run) == before


def test_one_trial(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = results(run)
    assert main([str(run), "--trial=drawn.yaml::pd::seed1"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "drawn.yaml::pd::seed1: success"
    assert lines[1].startswith("reached the goal after ")
    assert lines[2] == "repeat: pytest drawn.yaml::pd::seed1"
    assert lines[3].split() == ["kpi", "value", "unit", "group"]
    assert any(line.startswith("solver_time_p95_ms ") for line in lines)
    assert results(run) == before


def test_video_of_one_trial(run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    trial = "drawn.yaml::pd::seed1"
    for file in (run / "trials").rglob("*.parquet"):
        if file.relative_to(run / "trials") != Path("drawn/pd/seed1.parquet"):
            file.write_bytes(b"never read")
    before, raw = results(run), raw_data(run)
    for name in ("out.mp4", "out.gif"):
        assert main([str(run), "--trial", trial, "--video", str(tmp_path / name), "--fps=8"]) == 0
        assert capsys.readouterr().out == f"video: {tmp_path / name}\n"
        assert (tmp_path / name).stat().st_size > 1000
    assert results(run) == before
    assert raw_data(run) == raw


@pytest.mark.parametrize("options", [["--planners=pd"], ["--planners=pd", "--scenarios=drawn"]])
def test_a_report_of_a_selection_tells_of_nothing_else(run: Path, options: list[str]) -> None:
    assert main([str(run), *options]) == 0
    html = (run / "selected/report.html").read_text("utf-8")
    assert f"1 planner · {3 - len(options)} scenario" in html
    assert "has no finished trial" not in html
    assert "potential_field" not in html.replace("--lpb-planners=pd,potential_field", "")


def test_comparison(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([str(run), "--compare=pd,potential_field"]) == 0
    output = capsys.readouterr().out
    assert "a = pd, b = potential_field" in output
    assert any(line.startswith("success ") for line in output.splitlines())
    assert not [line for line in output.splitlines() if line.split()[1:2] == ["0"] and line.endswith("inconclusive")]
    (without,) = (line for line in output.splitlines() if line.startswith("no problem has a value of both: "))
    assert "final_goal_error_rad" in without
    rows = read_table(run / "selected/comparisons.csv")
    assert {(row["planner_a"], row["planner_b"]) for row in rows} == {("pd", "potential_field")}


def test_plots(run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    plugin = tmp_path / "my_plots.py"
    plugin.write_text(
        "from pytest_lpb import plot\n\n"
        '@plot(name="own", scope="run")\n'
        "def own(trajectories, axes):\n"
        "    axes.plot([0, 1], [0, 1])\n"
    )
    out = tmp_path / "out"
    assert main([str(run), "--plugin", str(plugin), "--plot=own", "--output", str(out)]) == 0
    assert "plots: " in capsys.readouterr().out
    files = [path for path in (out / "plots").rglob("*") if path.is_file()]
    assert {path.suffix for path in files} == {".png", ".pdf"}
    assert all("own" in path.name for path in files)
    sys.modules.pop("my_plots")


def test_plots_in_one_format(run: Path) -> None:
    before = raw_data(run)
    assert main([str(run), "--plot=success,kpi", "--plot-format=pdf", "--kpis=path_length_m"]) == 0
    files = {path.name for path in (run / "selected" / "plots").rglob("*") if path.is_file()}
    assert files == {"success.pdf", "path_length_m.pdf"}
    assert raw_data(run) == before


def test_export(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([str(run), "--export=latex,markdown"]) == 0
    assert (
        f"tables: summary.tex, comparisons.tex, summary.md, comparisons.md in {run / 'tables'}"
        in capsys.readouterr().out
    )
    summary = (run / "tables" / "summary.md").read_text(encoding="utf-8")
    assert "time to goal if reached \\[s\\]" in summary
    assert main([str(run), "--export=markdown", "--kpis=ldj", "--output", str(run / "other")]) == 0
    head = (run / "other" / "tables" / "summary.md").read_text(encoding="utf-8").splitlines()[2]
    assert head == "| scenario | planner | solved | problems | rate \\[%\\] | ldj |"


KPI = """
from pytest_lpb import kpi

@kpi(name="y_max_m", unit="m", direction="higher", over="all")
def y_max(trajectory):
    return trajectory.link("body")[:, 1].max()
"""


@pytest.mark.parametrize("by_path", [True, False])
def test_plugins(
    project: Project, run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, *, by_path: bool
) -> None:
    name = f"late_kpis_{int(by_path)}"
    file = tmp_path / f"{name}.py"
    file.write_text(KPI)
    monkeypatch.syspath_prepend(tmp_path)
    plugin = str(file) if by_path else name
    assert main([str(run), "--plugin", plugin, "--output", str(tmp_path / "out")]) == 0
    assert all(row["y_max_m"] for row in read_table(tmp_path / "out/trials.csv"))
    sys.modules.pop(name)


WRONG = {
    "no run": (["nowhere"], "nowhere is no run folder: it has no run.json"),
    "unknown planner": (
        ["--planners=pdd"],
        "no planner 'pdd' in this run; did you mean 'pd'?; there are pd, potential",
    ),
    "unknown scenario": (["--scenarios=drown"], "no scenario 'drown' in this run; did you mean 'drawn'?"),
    "unknown trial": (["--trial=drawn.yaml::pd::seed7"], "in this run; did you mean 'drawn.yaml::pd::seed"),
    "unknown KPI": (["--kpis=sparcs"], "unknown KPI 'sparcs'; did you mean 'sparc'"),
    "one planner to compare": (["--compare=pd"], "--compare takes two planners, found pd; write --compare=A,B"),
    "the same twice": (["--compare=pd,pd"], "--compare takes two planners, found pd, pd"),
    "unknown planner to compare": (["--compare=pd,potential_feld"], "did you mean 'potential_field'?"),
    "unknown plot": (["--plot=pahts"], "pahts"),
    "no module": (["--plugin=no_such_module"], "--plugin: cannot import 'no_such_module'"),
    "no file": (["--plugin=no_such_file.py"], "cannot load KPIs from no_such_file.py"),
    "output in a file": (["--output=/dev/null/x"], "cannot write /dev/null/x"),
    "video of what": (["--video=x.mp4"], "--video draws one trial; say which with --trial=NODEID"),
    "another kind of video": (
        ["--trial=drawn.yaml::pd::seed1", "--video=x.webm"],
        "--video: found 'x.webm'; a video's name ends with .gif, .mp4",
    ),
    "video of no trial": (
        ["--trial=drawn.yaml::pd::seed7", "--video=x.mp4"],
        "no trial 'drawn.yaml::pd::seed7' in this run; did you mean 'drawn.yaml::pd::seed",
    ),
    "video and more": (
        ["--trial=drawn.yaml::pd::seed1", "--video=x.mp4", "--kpis=sparc", "--plot"],
        "--video only draws; leave --kpis and --plot out",
    ),
    "too fast for a GIF": (
        ["--trial=drawn.yaml::pd::seed1", "--video=x.gif", "--fps=60"],
        "--fps: found 60; allowed for .gif are rates above 0 and up to 50 per second",
    ),
    "a rate without a video": (["--fps=10"], "--fps is for videos; add --trial=NODEID --video=FILE.mp4"),
}


@pytest.mark.parametrize(("arguments", "message"), WRONG.values(), ids=list(WRONG))
def test_wrong_arguments(run: Path, arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    before, raw = results(run), raw_data(run)
    given = arguments if arguments[0] == "nowhere" else [str(run), *arguments]
    assert main(given) == 4
    captured = capsys.readouterr()
    assert captured.err.startswith("lpb-report: error: ")
    assert message in captured.err
    assert results(run) == before
    assert raw_data(run) == raw


def test_a_misspelt_plot_is_told_before_anything_is_written(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([str(run), "--plot=clearence", "--planners=pd"]) == 4
    captured = capsys.readouterr()
    assert "unknown plot 'clearence'; did you mean 'clearance'" in captured.err
    assert captured.out == ""
    assert not (run / "selected").exists()


def test_a_folder_of_runs_names_them(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([str(run.parent)]) == 4
    assert f"run folders in {run.parent}: {run.name}" in capsys.readouterr().err


def test_a_broken_run_file(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (run / "run.json").write_text("{")
    assert main([str(run)]) == 4
    assert f"cannot read {run / 'run.json'}" in capsys.readouterr().err


def _cut(content: bytes) -> bytes:
    return content[: len(content) // 2]


def _empty(content: bytes) -> bytes:
    return b""


def _garbled(content: bytes) -> bytes:
    return content[:100] + bytes(200) + content[300:]


def _text(content: bytes) -> bytes:
    return b"no Parquet at all\n"


def _with_metadata(content: bytes, old: bytes, new: bytes) -> bytes:
    table = pyarrow.parquet.read_table(pyarrow.BufferReader(content))
    metadata = dict(table.schema.metadata)
    assert old in metadata[METADATA_KEY]
    metadata[METADATA_KEY] = metadata[METADATA_KEY].replace(old, new)
    sink = pyarrow.BufferOutputStream()
    pyarrow.parquet.write_table(table.replace_schema_metadata(metadata), sink)
    changed: bytes = sink.getvalue().to_pybytes()
    return changed


def _broken_metadata(content: bytes) -> bytes:
    return _with_metadata(content, b'"attempt":1', b'"attempt":}')


def _other_metadata(content: bytes) -> bytes:
    return _with_metadata(content, b'"planner":"pd"', b'"plonker":"pd"')


@pytest.mark.parametrize("damage", [_cut, _empty, _garbled, _text, _broken_metadata, _other_metadata])
def test_a_damaged_trial_file(run: Path, damage: object, capsys: pytest.CaptureFixture[str]) -> None:
    assert callable(damage)
    file = run / "trials/drawn/pd/seed1.parquet"
    damaged = damage(file.read_bytes())
    file.write_bytes(damaged)
    before = node_ids(run)
    raw = raw_data(run)
    assert main([str(run)]) == 1
    warnings = capsys.readouterr().err.splitlines()
    assert len(warnings) == 1
    assert warnings[0].startswith("lpb-report: warning: ")
    assert str(file) in warnings[0]
    assert before - node_ids(run) == {"drawn.yaml::pd::seed1"}
    assert raw_data(run) == raw


def test_a_run_without_trials(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    shutil.rmtree(run / "trials")
    assert main([str(run)]) == 0
    assert read_table(run / "trials.csv") == []
    assert (run / "report.html").is_file()


def test_version(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stop:
        main(["--version"])
    assert stop.value.code == 0
    assert capsys.readouterr().out.startswith("pytest-lpb ")


def test_abbreviated_options_are_refused(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stop:
        main([str(run), "--planner=pd"])
    assert stop.value.code == 4
    assert "--planner" in capsys.readouterr().err


def test_a_trial_file_of_another_trial(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    shutil.copy(run / "trials/drawn/pd/seed0.parquet", run / "trials/drawn/pd/seed7.parquet")
    assert main([str(run)]) == 1
    warning = "seed7.parquet holds the data of another trial, drawn.yaml::pd::seed0"
    assert warning in capsys.readouterr().err
    assert len(read_table(run / "trials.csv")) == 8


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--kpis="], "--kpis: found no name"),
        (["--compare=pd"], "--compare takes two planners, found pd"),
        (["--planners=pd", "--compare=pd,potential_field"], "--compare names a planner that --planners leaves out"),
        (["--trial=x", "--planners=pd"], "--trial shows one trial"),
        (["--plot", "--plot-format=gif"], "--plot-format: no format 'gif'"),
        (["--plot-format=pdf"], "--plot-format is for plots; add --plot"),
        (["--export=latx"], "--export: no format 'latx'; there are latex, markdown; did you mean 'latex'?"),
        (["--export="], "--export: found no name"),
        (["--trial=x", "--export=latex"], "--export writes tables of all trials"),
        (["--inconclusive=fail"], "--inconclusive: nothing to compare with; add --baseline"),
    ],
)
def test_options_that_contradict_each_other(
    run: Path, options: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([str(run), *options]) == 4
    assert message in capsys.readouterr().err


def test_code_in_a_run_folder_is_not_loaded(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    evil = run / "evil.py"
    evil.write_text("from pathlib import Path\nPath(__file__).with_name('ran').touch()\n", "utf-8")
    information = json.loads((run / "run.json").read_text("utf-8"))
    for file in (str(evil), "evil.py"):
        information["plugins"] = [{"module": "evil", "file": file}]
        (run / "run.json").write_text(json.dumps(information), "utf-8")
        assert main([str(run)]) == 1
        assert "'evil' lies in the run folder" in capsys.readouterr().err
    assert not (run / "ran").exists()


def test_several_runs_are_one(run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    copies = [tmp_path / f"20261122T02492{number}Z-{letter * 6}" for number, letter in enumerate("ab")]
    for copy in copies:
        shutil.copytree(run, copy)
    info = json.loads((copies[1] / "run.json").read_text())
    info["planners"]["pd"]["source_hash"] = "another"
    (copies[1] / "run.json").write_text(json.dumps(info))
    main([*map(str, copies), "--kpis=time_to_goal_s"])
    output = capsys.readouterr().out
    folder = tmp_path / "merged-aaaaaa-bbbbbb/selected"
    assert f"report: {folder / 'report.html'}" in output
    assert "pd.aaaaaa" in output
    assert "pd.bbbbbb" in (folder / "comparisons.csv").read_text()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--video=x.gif", "--trial=x"], "--video is about one run, found 2"),
        (["--retime"], "--retime is about one run, found 2"),
    ],
)
def test_what_is_about_one_run(run: Path, options: list[str], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([str(run), str(run), *options]) == 4
    assert message in capsys.readouterr().err


def test_runs_that_can_be_repeated(run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    copy = tmp_path / "copy"
    shutil.copytree(run, copy)
    write_planner_files(copy, find_planners(["pd", "potential_field"], []))
    assert main([str(copy), "--reproduce"]) == 0
    output = capsys.readouterr().out
    assert "run it again from the run folder alone" in output
    assert "--lpb-problems=" in output
    assert main([str(copy), str(run), "--reproduce"]) == 0
    assert f"8 of 8 trials of copy and {run.name} are the same to the last bit" in capsys.readouterr().out
    (copy / "trials/drawn/pd/seed0.parquet").unlink()
    assert main([str(copy), str(run), "--reproduce"]) == 1
    assert f"drawn :: pd :: seed0: only in {run.name}" in capsys.readouterr().out
    assert main([str(copy), str(run), str(run), "--reproduce"]) == 4


@pytest.mark.parametrize(
    ("error", "code", "said"),
    [
        (KeyboardInterrupt(), 2, "lpb-report: interrupted; nothing is half written\n"),
        (OSError(28, "No space left on device"), 4, "No space left on device; free space there; see --output"),
    ],
)
def test_what_stops_it_leaves_the_old_files(
    run: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    error: BaseException,
    code: int,
    said: str,
) -> None:
    def stop(self: Path, target: Path) -> None:
        raise error

    before = results(run)
    monkeypatch.setattr(Path, "replace", stop)
    assert main([str(run)]) == code
    assert said in capsys.readouterr().err
    monkeypatch.undo()
    assert results(run) == before
    assert not list(run.rglob(".*"))
