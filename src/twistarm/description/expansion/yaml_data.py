"""YAML for xacro: plain data, counted before it is built, with xacro's units."""

from __future__ import annotations

import io
from collections.abc import Callable, Mapping
from typing import Any

from ..yaml_reading import MAX_NUMBER, NUMBERS, safe_loader
from .work import LONG_INTEGER_COST, Refused, Work

NODE_COST = 50
"""PyYAML in Python takes that many units for a node."""

CHARACTER_COST = 0.6

MAX_SHORT = 18
"""Digits of a whole number that shares its hash with no other."""


def load_yaml(text: str, name: str, units: Mapping[str, Callable[[str], float]], work: Work) -> Any:
    """The data in a YAML text; `units`: what stands for a tag such as `!degrees`.

    No tag makes an object, aliases count as often as they are used, and what contains itself is refused. `name` is
    the file's, for PyYAML's messages.
    """
    import yaml  # type: ignore[import-untyped,unused-ignore]

    class Loader(safe_loader(yaml)):  # type: ignore[misc,unused-ignore]
        def compose_node(self, parent: Any, index: Any) -> Any:
            work.charge(NODE_COST)
            return super().compose_node(parent, index)

    for tag, unit in units.items():
        Loader.add_constructor(tag, lambda loader, node, unit=unit: unit(loader.construct_scalar(node)))
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


class Dotted(dict[str, Any]):
    """A dictionary whose items an expression may write behind a dot. xacro's own copies the item at each look."""

    __slots__ = ()

    def __getitem__(self, key: str) -> Any:
        try:
            return super().__getitem__(key)
        except KeyError:
            raise AttributeError(f"The yaml dictionary has no key '{key}'") from None


def dotted(value: Any) -> Any:
    """Plain data with every dictionary in it `Dotted`, what is shared still shared."""
    return _dotted(value, {})


def _dotted(value: Any, made: dict[int, Any]) -> Any:
    if not isinstance(value, (dict, list)):
        return value
    if id(value) not in made:
        if isinstance(value, dict):
            made[id(value)] = Dotted({key: _dotted(item, made) for key, item in value.items()})
        else:
            made[id(value)] = [_dotted(item, made) for item in value]
    return made[id(value)]


def _written_out(node: Any, sizes: dict[int, int]) -> int:
    """How many nodes there are when every alias is written out."""
    size = sizes.get(id(node))
    if size == 0:
        raise Refused("xacro-recursion", "the YAML contains itself", "write it without the alias")
    if size is None:
        sizes[id(node)] = 0
        size = sizes[id(node)] = _own_size(node) + sum(_written_out(child, sizes) for child in _children(node))
    return size


def _own_size(node: Any) -> int:
    if node.tag not in NUMBERS:
        return 1
    if len(node.value) > MAX_NUMBER:
        raise Refused("xacro-too-large", f"a number of more than {MAX_NUMBER} characters", "write it shorter")
    return LONG_INTEGER_COST if len(node.value) > MAX_SHORT else 1


def _children(node: Any) -> list[Any]:
    if isinstance(node.value, str):
        return []
    return [child for item in node.value for child in (item if isinstance(item, tuple) else (item,))]
