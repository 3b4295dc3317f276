"""`lpb-report` on 1,000 trials that were run, in the plane and in space: seconds, memory and size of the page."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from pytest_benchmark.fixture import BenchmarkFixture

from .test_runs import measured

SHIPPED = Path(__file__).parents[2] / "scenarios"
SCENARIOS = ("point/two_circles_random", "planar_arm/reachable_goals", "panda/random_spheres")
PLANNERS = ("pd", "potential_field", "fabrics")
SEEDS = 112
MEMORY_MIB = 1024
REPORT = "import sys; from pytest_lpb.cli import main; sys.exit(main(sys.argv[1:]))"


def run_trials(folder: Path, seeds: int) -> Path:
    """A run folder of `seeds` trials of each planner in each scenario."""
    options = [f"--lpb-planners={','.join(PLANNERS)}", f"--lpb-trials={seeds}", "--lpb-assert=none", "-n", "2"]
    files = [str(SHIPPED / f"{scenario}.yaml") for scenario in SCENARIOS]
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *options, *files]
    subprocess.run(command, cwd=folder, check=True, capture_output=True)
    return (folder / "reports" / "latest").resolve()


def test_report_of_1_000_trials(benchmark: BenchmarkFixture, tmp_path: Path) -> None:
    run = run_trials(tmp_path, SEEDS)
    for name in ("trials.csv", "summary.csv", "comparisons.csv", "report.html"):
        (run / name).unlink()
    command = [sys.executable, "-c", REPORT, str(run)]
    figures = benchmark.pedantic(measured, args=command, kwargs={"cwd": tmp_path}, rounds=1)  # type: ignore[no-untyped-call]
    trials = (run / "trials.csv").read_text(encoding="utf-8").count("\n") - 1
    size = (run / "report.html").stat().st_size
    benchmark.extra_info.update(
        trials=trials,
        s=round(figures["s"], 1),
        cpu_s=round(figures["cpu_s"], 1),
        peak_mib=round(figures["peak_mib"]),
        report_bytes=size,
    )
    assert trials == SEEDS * len(SCENARIOS) * len(PLANNERS)
    assert figures["peak_mib"] < MEMORY_MIB
    assert size < 5_000_000
