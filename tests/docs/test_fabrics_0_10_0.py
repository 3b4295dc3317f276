"""The example with the published fabrics 0.10.0: in its own virtual environment it does what ours does."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from pytest_lpb.trial.files import read_trial

EXAMPLE = Path(__file__).parents[2] / "docs" / "examples" / "fabrics_0_10_0"
INSTALL_S = 240.0  # [s] it takes half a minute on a fast line
# What pip says where there is no registry.
OFFLINE = (
    "No matching distribution",
    "Could not find a version",
    "Failed to establish",
    "Connection",
    "Temporary failure",
)


@pytest.fixture(scope="module")
def environment(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A virtual environment with fabrics 0.10.0; LPB_TEST_FABRICS_VENV names one that is there."""
    given = os.environ.get("LPB_TEST_FABRICS_VENV")
    if given:
        return Path(given)
    folder = tmp_path_factory.mktemp("fabrics") / "venv"
    subprocess.run([sys.executable, "-m", "venv", str(folder)], check=True)
    python = str(folder / "bin" / "python")
    # Python compiles what it imports: a small part of what is installed.
    options = ["--quiet", "--prefer-binary", "--no-compile"]
    command = [python, "-m", "pip", "install", *options, "fabrics==0.10.0"]
    # What this interpreter is told does not hold for that one.
    variables = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    try:
        result = subprocess.run(command, capture_output=True, text=True, check=False, timeout=INSTALL_S, env=variables)
    except subprocess.TimeoutExpired:
        pytest.skip(f"installing fabrics 0.10.0 took longer than {INSTALL_S:g} s")
    if result.returncode and any(text in result.stderr for text in OFFLINE):
        pytest.skip(f"no registry to install fabrics 0.10.0 from: {result.stderr.strip().splitlines()[-1]}")
    assert result.returncode == 0, result.stderr
    return folder


def test_the_published_release_does_what_ours_does_with_its_parameters(environment: Path, tmp_path: Path) -> None:
    project = tmp_path / "project"
    shutil.copytree(EXAMPLE, project, ignore=shutil.ignore_patterns("venv", "reports", "__pycache__"))
    (project / "venv").symlink_to(environment)
    (project / "pytest.ini").write_text("[pytest]\n")
    command = [sys.executable, "-m", "pytest", "-n", "0", "-p", "no:cacheprovider", "study.yaml"]
    result = subprocess.run(command, cwd=project, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stdout
    run = next((project / "reports").glob("2*"))
    for scenario, steps in (("point", 50), ("panda", 200)):
        published, same = (
            read_trial(run / "trials" / scenario / name / "seed0.parquet")
            for name in ("fabrics_0_10_0", "fabrics_same")
        )
        assert published.outcome == same.outcome == "success"
        assert len(published) == len(same) > steps
        # Another version of NumPy and another order of sums, over hundreds of steps.
        np.testing.assert_allclose(published.q, same.q, atol=1e-5)
        np.testing.assert_allclose(published.action[:steps], same.action[:steps], rtol=1e-5, atol=1e-5)
        assert (published.columns["planner_round_trip_ms"][:-1] > 0.0).all()
    about = subprocess.run(
        [
            project / "venv" / "bin" / "python",
            "-c",
            "import numpy, pytest; print(numpy.__version__, pytest.__version__)",
        ],
        capture_output=True,
        text=True,
        check=True,
    )
    assert about.stdout.startswith("1.")
    assert about.stdout.split()[1] == "6.2.5"
