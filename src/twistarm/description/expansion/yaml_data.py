"""YAML for xacro: plain data, counted before it is built, with xacro's units."""

from __future__ import annotations

import io
from collections.abc import Callable, Mapping
from typing import Any

from ..yaml_reading import MAX_NUMBER, NUMBERS, safe_loader
from .work import Refused, Work

NODE_COST = 50
"""Units that PyYAML in Python takes for a node."""

CHARACTER_COST = 0.6

MAX_SHORT = 18
"""Digits of a whole number that shares its hash with no other."""


def load_yaml(text: str, name: str, units: Mapping[str, float], number: Callable[[str], float], work: Work) -> Any:
    """The data in a YAML text.

    `units` gives the factor of a tag such as `!degrees`, and `number` evaluates the text behind it. No tag makes an
    object. Each use of an alias counts. Data that contains itself is refused. PyYAML's messages show `name`.
    """
    import yaml  # type: ignore[import-untyped,unused-ignore]

    class Loader(safe_loader(yaml)):  # type: ignore[misc,unused-ignore]
        def compose_node(self, parent: Any, index: Any) -> Any:
            work.charge(NODE_COST)
            return super().compose_node(parent, index)

    for tag, unit in units.items():
        Loader.add_constructor(tag, lambda loader, node, unit=unit: number(loader.construct_scalar(node)) * unit)
    work.charge(int(CHARACTER_COST * len(text)))
    stream = io.StringIO(text)
    stream.name = name
    loader = Loader(stream)
    try:
        root = loader.get_single_node()
        if root is None:
            return None
        work.charge(_written_out(root, {}))
        return loader.construct_document(root)
    except (RecursionError, yaml.YAMLError) as error:
        if isinstance(error, yaml.YAMLError) and "nesting depth" not in str(error):  # libyaml's own limit
            raise
        raise Refused("xacro-too-large", "the YAML is nested too deeply", "write it flatter") from None
    finally:
        loader.dispose()


def _written_out(node: Any, sizes: dict[int, int]) -> int:
    """The number of nodes with every alias written out."""
    size = sizes.get(id(node))
    if size == 0:
        raise Refused("xacro-recursion", "the YAML contains itself", "write it without the alias")
    if size is None:
        sizes[id(node)] = 0
        _require_short(node, MAX_NUMBER)
        children = [] if isinstance(node.value, str) else node.value
        if children and isinstance(children[0], tuple):
            for one, _ in children:
                _require_short(one, MAX_SHORT)
            children = [part for pair in children for part in pair]
        size = sizes[id(node)] = 1 + sum(_written_out(child, sizes) for child in children)
    return size


def _require_short(node: Any, most: int) -> None:
    if node.tag in NUMBERS and len(node.value) > most:
        what = f"a number of more than {most} characters"
        raise Refused("xacro-too-large", what, "write it shorter, or as a text")
