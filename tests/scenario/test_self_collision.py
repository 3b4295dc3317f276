"""Self-collision pairs that are excepted: by name, and by an SRDF file."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import pytest

from pytest_lpb.errors import ScenarioError
from pytest_lpb.problem.problem import Problem
from pytest_lpb.scenario.draw import check_feasible
from pytest_lpb.scenario.load import Scenario, load_scenario
from pytest_lpb.trial.assets import recorded
from tests.scenario.urdfs import joint, link, write_urdf

SRDF = """\
<robot name="telescope">
  <group name="arm"><chain base_link="mast" tip_link="stage2"/></group>
  <disable_collisions link1="stage2" link2="mast" reason="User"/>
  <disable_collisions link1="mast" link2="bare" reason="Never"/>
</robot>
"""
SCENARIO = """\
version: 1
robot: {urdf: telescope.urdf, self_collision_pairs: PAIRS}
environment: {engine: pybullet}
goal: [{name: out, type: joint, joints: [out1, out2], target: [0.2, 0.2], tolerance: 0.05}]
"""


def stage(width: float) -> str:
    return f'<collision><geometry><box size="0.5 {width} {width}"/></geometry></collision>'


def slide(name: str, parent: str, child: str) -> str:
    limit = 'lower="0" upper="0.4" velocity="1" effort="1"'
    slides = joint(name, parent, child, "prismatic", limit).replace("0 0 1", "1 0 0")
    return slides.replace('<origin xyz="0.5 0 0"/>', "")


def telescope(folder: Path, pairs: str, **files: str) -> Scenario:
    """Drawn in at its start: mast and stage2 overlap by design."""
    links = (link("mast", stage(0.1)), link("stage1", stage(0.08)), link("stage2", stage(0.06)), link("bare", ""))
    joints = (
        slide("out1", "mast", "stage1"),
        slide("out2", "stage1", "stage2"),
        joint("tip", "stage2", "bare", "fixed"),
    )
    write_urdf(folder / "telescope.urdf", (*links, *joints))
    for name, content in files.items():
        (folder / f"{name}.srdf").write_text(content, "utf-8")
    scenario = folder / "a.yaml"
    scenario.write_text(SCENARIO.replace("PAIRS", pairs), "utf-8")
    return load_scenario(scenario)


def pairs_of(scenario: Scenario) -> Any:
    return Problem.from_dict(scenario.concrete).robot.self_collision_pairs


def test_a_start_in_self_collision_names_the_pair_and_the_way_out(tmp_path: Path) -> None:
    scenario = telescope(tmp_path, "null")
    assert pairs_of(scenario) == (("mast", "stage2"),)
    with pytest.raises(ScenarioError) as refused:
        check_feasible(scenario, ())
    _, _, way_out = str(refused.value).partition("if they overlap by design, ")
    assert "'mast' is 0.08 m inside 'stage2'; choose another start, or if" in str(refused.value)
    assert way_out.splitlines()[0] == "robot: {self_collision_pairs: {except: [[mast, stage2]]}}"
    check_feasible(telescope(tmp_path, "{except: [[mast, stage2]]}"), ())
    with pytest.raises(ScenarioError, match=r"by design, take \[mast, stage2\] out of self_collision_pairs"):
        check_feasible(telescope(tmp_path, "[[mast, stage2]]"), ())


@pytest.mark.parametrize(
    "pairs",
    ["{except: [[stage2, mast]]}", "{srdf: arm.srdf}", "{except: [[mast, stage2]], srdf: arm.srdf}"],
)
def test_excepted_pairs_may_overlap(pairs: str, tmp_path: Path) -> None:
    scenario = telescope(tmp_path, pairs, arm=SRDF)
    assert pairs_of(scenario) == ()
    (found,) = scenario.concrete["robot"]["self_collision_pairs"]["except"]
    assert set(found) == {"mast", "stage2"}


def test_problems_need_the_srdf_no_more_and_others_keep_their_hash(tmp_path: Path) -> None:
    scenario = telescope(tmp_path, "{srdf: arm.srdf}", arm=SRDF)
    problem = Problem.from_dict(scenario.concrete)
    (tmp_path / "arm.srdf").unlink()
    copied = recorded(scenario.concrete, tmp_path / "run")["robot"]
    assert copied["self_collision_pairs"] == {"except": [["stage2", "mast"]]}
    again = load_scenario(write(tmp_path / "b.yaml", "{except: [[stage2, mast]]}"))
    assert Problem.from_dict(again.concrete).problem_hash == problem.problem_hash
    assert load_scenario(write(tmp_path / "c.yaml", "null")).concrete["robot"]["self_collision_pairs"] is None
    listed = load_scenario(write(tmp_path / "d.yaml", "[[mast, stage2]]")).concrete["robot"]["self_collision_pairs"]
    assert listed == [["mast", "stage2"]]


def test_an_edited_srdf_file_is_read_again_even_with_its_old_size_and_time(tmp_path: Path) -> None:
    assert pairs_of(telescope(tmp_path, "{srdf: arm.srdf}", arm=SRDF)) == ()
    path = tmp_path / "arm.srdf"
    stat = path.stat()
    edited = SRDF.replace('link1="stage2"', 'link1="stage1"')
    assert len(edited) == stat.st_size
    path.write_text(edited, "utf-8")
    os.utime(path, ns=(stat.st_atime_ns, stat.st_mtime_ns))
    assert pairs_of(load_scenario(tmp_path / "a.yaml")) == (("mast", "stage2"),)


def write(path: Path, pairs: str) -> Path:
    path.write_text(SCENARIO.replace("PAIRS", pairs), "utf-8")
    return path


def test_defaults_of_a_link_can_be_disabled(tmp_path: Path) -> None:
    disabled = '<robot><disable_default_collisions link="mast"/>ENABLED</robot>'
    enabled = '<enable_collisions link1="stage2" link2="mast"/>'
    assert pairs_of(telescope(tmp_path, "{srdf: a.srdf}", a=disabled.replace("ENABLED", ""))) == ()
    scenario = telescope(tmp_path, "{srdf: a.srdf}", a=disabled.replace("ENABLED", enabled))
    assert pairs_of(scenario) == (("mast", "stage2"),)


@pytest.mark.parametrize(
    ("pairs", "srdf", "message"),
    [
        ("{}", "", "a.yaml:2: robot.self_collision_pairs: found neither except nor srdf; one of them, or both, are"),
        ("{but: []}", "", "robot.self_collision_pairs.but: unknown key; allowed: except, srdf"),
        ("5", "", "robot.self_collision_pairs: found 5; a list is required"),
        ("{except: [[mast, stage3]]}", "", "self_collision_pairs.except[0][1]: unknown body 'stage3'; did you mean"),
        ("{except: [[mast]]}", "", "except[0]: found a list of 1; at least 2 entries are required"),
        ("{srdf: none.srdf}", "", "self_collision_pairs.srdf: there is no file {here}/none.srdf"),
        ("{srdf: telescope.urdf}", "", "srdf: found 'telescope.urdf'; the name of an SRDF file ends in .srdf"),
        ("{srdf: ../../up.srdf}", "", "self_collision_pairs.srdf: {above}/up.srdf lies outside of"),
        ("{srdf: x.srdf}", '<robot>\n<disable_collisions link1="mast" link2="stag2"/></robot>',
         "srdf: {here}/x.srdf:2: <disable_collisions> link2: no link 'stag2'; did you mean 'stage2'"),
        ("{srdf: x.srdf}", "<robot><disable_collisions link1='mast'/></robot>", "x.srdf:1: <disable_collisions> has"),
        ("{srdf: x.srdf}", "<sdf/>", "x.srdf:1: found <sdf>; an SRDF file has a <robot>"),
        ("{srdf: x.srdf}", "<robot><link name='a'/></robot>", "x.srdf:1: found links or joints; this is"),
        ("{srdf: x.srdf}", "<robot>", "x.srdf:1: is no XML: no element found"),
        ("{srdf: x.srdf}", "<!DOCTYPE a><robot/>", "x.srdf:1: found a DOCTYPE; a SRDF file has none"),
    ],
)  # fmt: skip
def test_what_cannot_be_excepted(pairs: str, srdf: str, message: str, tmp_path: Path) -> None:
    folder = tmp_path / "mine/scenarios"
    folder.mkdir(parents=True)
    (folder / "pytest.ini").write_text("")
    with pytest.raises(ScenarioError) as refused:
        telescope(folder, pairs, x=srdf)
    assert message.format(here=folder, above=tmp_path) in str(refused.value)


def test_planar_arms_take_exceptions_too(tmp_path: Path) -> None:
    path = tmp_path / "arm.yaml"
    path.write_text(
        "version: 1\n"
        "robot: {model: planar_arm, links: 3, self_collision_pairs: {except: [[base, link3]]}}\n"
        "goal: [{name: reach, type: position, link: end, target: [1.0, 1.0], tolerance: 0.1}]\n"
    )
    assert pairs_of(load_scenario(path)) == (("base", "link2"), ("link1", "link3"))


def test_all_pairs_that_overlap_at_the_start_are_named(tmp_path: Path) -> None:
    """A planar arm of five links, folded onto itself."""
    path = tmp_path / "arm.yaml"
    path.write_text(
        "version: 1\n"
        "robot: {model: planar_arm, links: 4}\n"
        "start: {q: [0, 3.1415926, 3.1415926, 3.1415926]}\n"
        "goal: [{name: reach, type: position, link: end, target: [1.0, 1.0], tolerance: 0.1}]\n"
    )
    with pytest.raises(ScenarioError) as refused:
        check_feasible(load_scenario(path), ())
    named = str(refused.value).partition("except: ")[2].splitlines()[0]
    assert all(pair in named for pair in ("[base, link2]", "[base, link4]", "[link1, link3]", "[link2, link4]"))
