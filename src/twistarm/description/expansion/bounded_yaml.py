"""YAML in xacro's expressions, without objects and bombs."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from typing import Any, TextIO

MAX_NUMBER, MAX_KEY = 400, 18
"""Characters of a number. Long numbers in base 60, which YAML has, take long to compute, and long keys share hashes."""

_NUMBERS = ("tag:yaml.org,2002:int", "tag:yaml.org,2002:float")


def is_deep(error: Exception) -> bool:
    """Whether the text nests too deeply. Newer versions of libyaml have a limit, too."""
    return isinstance(error, RecursionError) or "nesting depth" in str(error)


def bounded_loader(
    problem: Callable[[int], str], units: Mapping[str, float], number: Callable[[str], float], *, strict: bool = False
) -> Any:
    """A class of safe loaders for PyYAML. Tags on PyYAML's loader would hold for the whole process.

    `problem` takes the values in each node, aliases written out, and tells why there may be no more. `units` gives the
    factor of a tag such as `!degrees`, and `number` evaluates the text behind it. `strict` refuses keys that are given
    twice, and numbers in base 60.
    """
    import yaml

    def refuse(problem: str, node: Any) -> None:
        raise yaml.constructor.ConstructorError(None, None, problem, node.start_mark)

    class Loader(_safe_loader(yaml)):  # type: ignore[misc,unused-ignore]
        # xacro registers tags of its own on PyYAML's, and evaluates what stands behind them.
        yaml_constructors = {  # noqa: RUF012
            tag: made for tag, made in yaml.SafeLoader.yaml_constructors.items() if not str(tag).startswith("!")
        }

        def __init__(self, stream: str | TextIO) -> None:
            super().__init__(stream)
            self.count = 0
            self.sizes: dict[int, int] = {}

        def compose_node(self, parent: Any, index: Any) -> Any:
            event, before = self.peek_event(), self.count
            node = super().compose_node(parent, index)
            alias = isinstance(event, yaml.events.AliasEvent)
            if alias and id(node) not in self.sizes:
                refuse("an alias inside its own value", event)
            size = self.sizes[id(node)] if alias else 1
            self.count += size
            self.sizes.setdefault(id(node), self.count - before)
            if why := problem(size) or _bad_number(node, MAX_NUMBER, strict):
                refuse(why, event)
            return node

        def compose_mapping_node(self, anchor: Any) -> Any:
            node = super().compose_mapping_node(anchor)
            for key, _ in node.value:
                if why := _bad_number(key, MAX_KEY):
                    refuse(why, key)
            keys = Counter(key.value for key, _ in node.value if strict and isinstance(key.value, str))
            twice = next((key for key, times in keys.items() if times > 1), None)
            if twice is not None:
                refuse(f"{twice!r} stands there twice", node)
            return node

    def with_unit(loader: Any, tag: str, node: Any) -> float:
        if "!" + tag not in units:
            refuse(f"the tag !{tag} is unknown; allowed: {', '.join(units)}", node)
        return number(loader.construct_scalar(node)) * units["!" + tag]

    Loader.add_multi_constructor("!", with_unit)
    return Loader


def _bad_number(node: Any, most: int, strict: bool = False) -> str:
    """Why a number is refused. Empty for usual numbers and other values."""
    if node.tag not in _NUMBERS:
        return ""
    if len(node.value) > most:
        return f"a number of more than {most} characters"
    return f"{node.value} is a number in base 60; write it in base 10" if strict and ":" in node.value else ""


def _safe_loader(yaml: Any) -> Any:
    """PyYAML's safe loader, on libyaml's parser if PyYAML has it, which takes a fifth of the time."""
    if not yaml.__with_libyaml__:
        return yaml.SafeLoader

    bases = yaml.composer.Composer, yaml.cyaml.CParser, yaml.constructor.SafeConstructor, yaml.resolver.Resolver

    class Loader(*bases):  # type: ignore[misc]
        def __init__(self, stream: str | TextIO) -> None:
            yaml.cyaml.CParser.__init__(self, stream)
            for base in (bases[0], *bases[2:]):
                base.__init__(self)

    return Loader
