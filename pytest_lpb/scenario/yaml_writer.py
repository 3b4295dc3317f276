"""Write plain data as YAML that `read_yaml`, and any other YAML reader, reads back as the same data."""

import re
from typing import Any

import yaml

from pytest_lpb.scenario.yaml_core import BASED_INTEGER, FLOAT


class _Dumper(yaml.SafeDumper):
    """Quotes text that YAML 1.2 would take for a number, besides what YAML 1.1 would."""

    def ignore_aliases(self, data: Any) -> bool:  # noqa: ARG002 - PyYAML's signature
        return True


def _text(dumper: yaml.SafeDumper, text: str) -> yaml.ScalarNode:
    # PyYAML's other styles lose line breaks such as U+0085; double quotes escape them.
    style = None if text.isprintable() else '"'
    return dumper.represent_scalar("tag:yaml.org,2002:str", text, style=style)


_Dumper.add_representer(str, _text)
_NUMBER = re.compile(f"(?:{FLOAT.pattern}|{BASED_INTEGER.pattern})$")
_Dumper.add_implicit_resolver("tag:yaml.org,2002:float", _NUMBER, list("-+.0123456789"))


def dump_yaml(data: dict[str, Any]) -> str:
    """Plain data (mappings, lists, text, finite numbers, booleans, None) as YAML in the order given."""
    text: str = yaml.dump(data, Dumper=_Dumper, sort_keys=False, default_flow_style=None, allow_unicode=True, width=120)
    return text
