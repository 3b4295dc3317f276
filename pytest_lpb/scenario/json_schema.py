"""The JSON Schema of scenario files, for editors: completion, and errors while typing.

`python -m pytest_lpb.scenario.json_schema` writes the shipped `scenario.schema.json` anew. Loading a scenario
does not use it: what involves several keys is beyond JSON Schema.
"""

import json
from pathlib import Path
from typing import Any

from pytest_lpb.scenario.schema.registered import scenario_model

SCHEMA_FILE = Path(__file__).with_name("scenario.schema.json")
DIALECT = "https://json-schema.org/draft/2020-12/schema"


def scenario_json_schema() -> dict[str, Any]:
    """The schema as plain data, with what users have registered in this process."""
    return {"$schema": DIALECT, **scenario_model().model_json_schema(), "title": "pytest-lpb scenario"}


def schema_text() -> str:
    """The content of the shipped file."""
    return json.dumps(scenario_json_schema(), indent=1, sort_keys=True, allow_nan=False) + "\n"


def main() -> None:
    """Write the shipped file."""
    SCHEMA_FILE.write_text(schema_text(), encoding="utf-8")


if __name__ == "__main__":
    main()
