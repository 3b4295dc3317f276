import io
import math
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_lpb.run.tables import comparisons_table, summary_table, write_csv
from tests.run.trial_frames import KPIS, random_trials


def test_cells_are_written_as_the_contract_says(tmp_path: Path) -> None:
    frame = pd.DataFrame(
        {
            "name": ["a,b", 'say "x"', None],
            "count": [1, 2, 3],
            "value": [0.1, math.nan, 1e-300],
            "flag": [True, False, True],
            "mixed": pd.Series([True, math.nan, 2], index=[7, 8, 9], dtype=object),
        },
        index=[7, 8, 9],
    )
    write_csv(frame, tmp_path / "x.csv")
    assert (tmp_path / "x.csv").read_bytes() == (
        b'name,count,value,flag,mixed\n"a,b",1,0.1,true,true\n"say ""x""",2,,false,\n,3,1e-300,true,2\n'
    )


@given(st.lists(st.floats(allow_infinity=False), min_size=1))
def test_numbers_read_back_exactly(tmp_path_factory: pytest.TempPathFactory, values: list[float]) -> None:
    path = tmp_path_factory.mktemp("csv") / "x.csv"
    write_csv(pd.DataFrame({"x": values, "y": values}), path)
    read = pd.read_csv(path)
    assert np.array_equal(read["x"].astype(float), values, equal_nan=True)


def test_shuffled_trials_give_the_same_bytes(tmp_path: Path) -> None:
    trials = random_trials("abc", seeds=8)
    for number, rows in enumerate([trials, trials.sample(frac=1, random_state=3), trials[::-1]]):
        write_csv(summary_table(rows, KPIS), tmp_path / f"summary{number}.csv")
        write_csv(comparisons_table(rows, KPIS), tmp_path / f"comparisons{number}.csv")
    for name in ("summary", "comparisons"):
        assert len({(tmp_path / f"{name}{number}.csv").read_bytes() for number in range(3)}) == 1


def test_a_table_read_back_and_written_again_is_the_same_bytes(tmp_path: Path) -> None:
    write_csv(comparisons_table(random_trials(), KPIS), tmp_path / "x.csv")
    first = (tmp_path / "x.csv").read_bytes()
    read = pd.read_csv(io.BytesIO(first))
    write_csv(read, tmp_path / "x.csv")
    assert (tmp_path / "x.csv").read_bytes() == first


def test_a_file_is_replaced_as_a_whole_and_nothing_is_left(tmp_path: Path) -> None:
    path = tmp_path / "x.csv"
    path.write_text("old")
    with pytest.raises(UnicodeEncodeError):
        write_csv(pd.DataFrame({"x": pd.Series(["\ud800"], dtype=object)}), path)
    assert path.read_text() == "old"
    write_csv(pd.DataFrame({"x": [1]}), path)
    assert [file.name for file in tmp_path.iterdir()] == ["x.csv"]
    assert path.read_text() == "x\n1\n"


@pytest.mark.skipif(sys.platform == "win32", reason="file modes")
def test_a_table_is_as_readable_as_any_other_file(tmp_path: Path) -> None:
    write_csv(pd.DataFrame({"x": [1]}), tmp_path / "x.csv")
    (tmp_path / "y.csv").write_text("")
    assert (tmp_path / "x.csv").stat().st_mode == (tmp_path / "y.csv").stat().st_mode


def test_values_that_diverged_are_no_values() -> None:
    """Their sums overflow, which is a warning and so an error here."""
    trials = random_trials(seeds=8)
    for sign in (1, -1):
        trials.loc[sign * trials["seed"] > sign * 4, "clearance_min_m"] = sign * 1.7e308
    summary, comparisons = summary_table(trials, KPIS), comparisons_table(trials, KPIS)
    assert summary.loc[summary["scenario"] == "all", "clearance_min_m_n"].tolist() == [2, 2]
    assert comparisons.loc[comparisons["kpi"] == "clearance_min_m", "pairs"].tolist() == [1, 1, 2]
