"""The page about KPIs says what the code does."""

import re
from pathlib import Path

from pytest_lpb.kpis.registry import BUILTIN_MODULES, default_registry, load_builtin

from .trials import make_problem, make_trial

PAGE = Path(__file__).parents[2] / "docs" / "kpis.md"


def test_the_table_lists_every_builtin_kpi_in_order_as_declared() -> None:
    rows = re.findall(r"^\| `(\S+)` \| (.+?) \| (\w+) \| (\w+) \| ", PAGE.read_text(encoding="utf-8"), re.MULTILINE)
    builtin = [entry for entry in load_builtin() if entry.module in BUILTIN_MODULES]
    assert rows == [(entry.name, entry.unit, entry.direction, entry.over) for entry in builtin]


def test_the_example_is_a_kpi() -> None:
    (example,) = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    with default_registry.preserved() as registry:
        exec(example, {"__name__": "example"})
        (entry,) = registry.select(["elbow_height_min_m"])
        trial = make_trial(make_problem(), make_problem().start_q[None])
        trial.columns = {**trial.columns, **{f"link_panda_link4_{axis}": trial.t for axis in "xyz"}}
        assert entry(trial) == 0.0
