import importlib
import subprocess
import sys
from functools import partial
from pathlib import Path

import pytest

from pytest_lpb.errors import KpiError
from pytest_lpb.kpis.registry import BUILTIN_MODULES, Registry, default_registry, kpi, load_builtin
from pytest_lpb.trajectory import Trajectory


def zero(trajectory: Trajectory) -> float:
    return 0.0


def one(trajectory: Trajectory) -> float:
    return 1.0


def register(registry: Registry, name: str = "mine", unit: str = "1", **changes: str) -> None:
    arguments = {"direction": "lower", "over": "all", **changes}
    registry.kpi(name, unit, **arguments)(zero)  # type: ignore[arg-type]


def test_decorator_keeps_the_function_and_its_declaration() -> None:
    registry = Registry()
    assert registry.kpi("height_m", "m", "higher", "solved", group="arm", timing=True)(zero) is zero
    (entry,) = registry
    assert (entry.name, entry.unit, entry.direction, entry.over) == ("height_m", "m", "higher", "solved")
    assert (entry.group, entry.timing, entry.restricted_to_duration) == ("arm", True, False)
    assert entry.module == __name__
    assert entry.function is zero
    assert "height_m" in registry
    assert len(registry) == 1


@pytest.mark.parametrize(
    ("name", "unit", "changes", "message"),
    [
        ("a,b", "1", {}, "a name begins with a letter"),
        ("=sum", "1", {}, "a name begins with a letter"),
        ("-x", "1", {}, "a name begins with a letter"),
        ("", "1", {}, "a name begins with a letter"),
        ("x" * 101, "1", {}, "a name begins with a letter"),
        ("outcome", "1", {}, "taken by a column"),
        ("hold_time", "s", {}, "taken by a column"),
        ("mine", "", {}, "unit is ''"),
        ("mine", "m\n", {}, "unit is"),
        ("length_m", "s", {}, "unit is 's', but the name says 'm'"),
        ("jerk_m_per_s3", "m/s^2", {}, r"but the name says 'm/s\^3'"),
        ("mine", "1", {"direction": "up"}, "direction is 'up'; allowed: higher, lower, none"),
        ("mine", "1", {"over": "failed"}, "over is 'failed'; allowed: all, solved"),
    ],
)
def test_wrong_declarations_are_refused(name: str, unit: str, changes: dict[str, str], message: str) -> None:
    registry = Registry()
    with pytest.raises(KpiError, match=message) as error:
        register(registry, name, unit, **changes)
    assert "test_registry.py:" in str(error.value)
    assert not registry


def test_what_is_no_function_is_refused() -> None:
    with pytest.raises(KpiError, match="3 is not a function of a trajectory"):
        Registry().kpi("mine", "1", "lower", "all")(3)  # type: ignore[type-var]


def test_the_same_name_from_another_function_names_both_places() -> None:
    registry = Registry()
    register(registry)
    with pytest.raises(KpiError, match=r"'mine' is defined twice: at .*test_registry.py:\d+ and at .*:\d+") as error:
        registry.kpi("mine", "1", "lower", "all")(one)
    assert str(error.value).count("test_registry.py") == 2
    assert [entry.function for entry in registry] == [zero]


def test_a_module_imported_again_replaces_its_kpis(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "lpb_own_kpis.py").write_text(
        "from pytest_lpb import kpi\n\n\n@kpi('own_m', 'm', 'lower', 'all')\ndef own(trajectory):\n    return 1.0\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    with default_registry.preserved() as registry:
        module = importlib.import_module("lpb_own_kpis")
        monkeypatch.delitem(sys.modules, "lpb_own_kpis")
        again = importlib.import_module("lpb_own_kpis")
        assert module is not again
        (entry,) = registry.select(["own_m"])
        assert entry.function is again.own
        assert entry.module == "lpb_own_kpis"
    assert "own_m" not in default_registry


def test_objects_and_partials_may_be_kpis() -> None:
    class Length:
        def __call__(self, trajectory: Trajectory) -> float:
            return 1.0

    registry = Registry()
    registry.kpi("object", "1", "lower", "all")(Length())
    registry.kpi("partial", "1", "lower", "all")(partial(zero))
    places = [entry.place for entry in registry]
    assert places[0].endswith("Length")
    assert "test_registry.py:" in places[1]
    assert {entry.module for entry in registry} == {__name__}


def test_select_keeps_the_registrys_order_and_drops_repeats() -> None:
    registry = load_builtin()
    found = [entry.name for entry in registry.select(["sparc", "time_to_goal_s", "sparc", "path_length_m"])]
    assert found == ["time_to_goal_s", "path_length_m", "sparc"]
    assert registry.select([]) == []
    assert registry.select() == list(registry)


def test_unknown_names_are_all_listed_with_suggestions() -> None:
    with pytest.raises(KpiError) as error:
        load_builtin().select(["path_lenght_m", "ldj", "zzz"])
    lines = str(error.value).splitlines()
    assert lines[0].startswith("unknown KPI 'path_lenght_m'; did you mean 'path_length_m'")
    assert lines[1] == "unknown KPI 'zzz'"
    assert lines[2].startswith("KPIs: action_squared_integral, ")


def test_builtin_kpis_come_first_whatever_is_imported_first() -> None:
    code = (
        "from pytest_lpb.kpis.registry import kpi, load_builtin\n"
        "kpi('mine', '1', 'lower', 'all')(lambda trajectory: 0.0)\n"
        "import pytest_lpb.kpis.timing\n"
        "print(*[entry.name for entry in load_builtin()])"
    )
    output = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert output.split() == [*[e.name for e in load_builtin() if e.module in BUILTIN_MODULES], "mine"]


def test_scipy_is_imported_only_when_a_kpi_needs_it() -> None:
    code = (
        "import sys\nfrom pytest_lpb.kpis.registry import load_builtin\nload_builtin()\nprint('scipy' in sys.modules)"
    )
    output = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert output.strip() == "False"


def test_the_public_decorator_registers_in_the_default_registry() -> None:
    with default_registry.preserved():
        kpi(name="mine", unit="1", direction="none", over="all")(zero)
        assert default_registry.select(["mine"])[0].group == "user"
    assert "mine" not in default_registry


def test_builtin_declarations() -> None:
    entries = {entry.name: entry for entry in load_builtin()}
    assert [name for name, entry in entries.items() if entry.restricted_to_duration] == ["time_to_goal_s"]
    assert {entry.group for entry in entries.values() if entry.timing} == {"timing"}
    assert all(entry.timing for entry in entries.values() if entry.group == "timing")
    assert "real_time_factor" in entries
