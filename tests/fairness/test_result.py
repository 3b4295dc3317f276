"""What the check found, written, read again and told; files of strangers."""

from pathlib import Path

import pytest

from pytest_lpb.errors import RecordingError
from pytest_lpb.fairness.result import Fairness, read_fairness

FOUND = Fairness(
    trials={"a": 2, "b": 1},
    random=["x :: a :: seed1"],
    unanswered={"x :: b :: seed1": "it left"},
    goal_unseen={"b": [f"s{index}" for index in range(7)]},
    obstacles_unseen={"a": ["x"]},
)


def test_what_is_written_is_read(tmp_path: Path) -> None:
    assert read_fairness(tmp_path) is None
    FOUND.write(tmp_path)
    read = read_fairness(tmp_path)
    assert read is not None
    assert [*read.faults(), *read.notes()] == [*FOUND.faults(), *FOUND.notes()]
    assert read.trials == FOUND.trials


def test_in_words() -> None:
    random, unanswered, unseen = FOUND.faults()
    assert random.endswith("the order of a set): x :: a :: seed1")
    assert unanswered == "isolation: x :: b :: seed1 could not be run again: it left"
    assert "in s0, s1, s2, s3, s4 and 2 more: it does not look at it" in unseen
    assert list(FOUND.notes()) == ["The first action of a depends on no obstacle's place in x."]


@pytest.mark.parametrize(
    "content",
    [
        "{",
        "[]",
        "{}",
        '{"schema_version": 2, "trials": {}}',
        '{"schema_version": 1}',
        '{"schema_version": 1, "trials": ["a"]}',
        '{"schema_version": 1, "trials": {"a": "many"}}',
        '{"schema_version": 1, "trials": {}, "blind": {"a": 3}}',
        "\xff",
    ],
)
def test_damaged_files(tmp_path: Path, content: str) -> None:
    (tmp_path / "fairness.json").write_bytes(content.encode("latin-1"))
    with pytest.raises(RecordingError, match=r"cannot read .*fairness\.json: .*; check the run again, or delete it"):
        read_fairness(tmp_path)
