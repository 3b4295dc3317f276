"""Keys of `per_robot` that match no robot of the run: told for files written for it, not for copies of others."""

from __future__ import annotations

import shutil
from pathlib import Path

from pytest_lpb.planner.files import find_planners
from pytest_lpb.plugin.collection import unmatched_robots
from pytest_lpb.run.folder import RUN_FILE
from pytest_lpb.shipped import shipped_folder

ROBOTS = [("point", "acceleration")]
SHIPPED = shipped_folder("planners") / "potential_field.yaml"


def test_copies_in_a_run_folder_are_for_the_robots_of_that_run(tmp_path: Path) -> None:
    mine = tmp_path / "mine/planners/potential_field.yaml"
    recorded = tmp_path / "run/planners/potential_field.yaml"
    for copy in (mine, recorded):
        copy.parent.mkdir(parents=True)
        shutil.copy(SHIPPED, copy)
    (tmp_path / "run" / RUN_FILE).write_text("{}", "utf-8")
    found = [unmatched_robots(find_planners([str(path)], []), ROBOTS) for path in (SHIPPED, recorded, mine)]
    assert found[:2] == ["", ""]
    assert found[2].startswith("per_robot: no robot of this run matches '@velocity' of planner 'potential_field'")
    assert found[2].endswith("there are point@acceleration")
