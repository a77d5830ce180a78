"""YAML for xacro: plain data, counted before it is built, with xacro's units."""

from __future__ import annotations

import io
from collections.abc import Callable, Mapping
from typing import Any

from ..yaml_reading import bounded_loader, is_deep
from .work import Refused, Work

NODE_COST = 50
"""Units that PyYAML in Python takes for a node."""

CHARACTER_COST = 0.6


def load_yaml(text: str, name: str, units: Mapping[str, float], number: Callable[[str], float], work: Work) -> Any:
    """The data in a YAML text, by `bounded_loader`. PyYAML's messages show `name`."""
    import yaml  # type: ignore[import-untyped,unused-ignore]

    def charge(nodes: int) -> str:
        work.charge(NODE_COST + nodes)
        return ""

    work.charge(int(CHARACTER_COST * len(text)))
    stream = io.StringIO(text)
    stream.name = name
    try:
        return yaml.load(stream, Loader=bounded_loader(charge, units, number))
    except (RecursionError, yaml.YAMLError) as error:
        if is_deep(error):
            raise Refused("xacro-too-large", "the YAML is nested too deeply", "write it flatter") from None
        raise
