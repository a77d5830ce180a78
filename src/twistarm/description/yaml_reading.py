"""YAML as plain data, with ROS's unit tags, without objects and bombs, and with errors in one line."""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path
from typing import Any, TextIO

import numpy as np

from .findings import Place, refusal

MAX_NODES = 50_000
"""Most values with every alias counted. A text with more is a bomb ("billion laughs")."""

MAX_NUMBER = 400
"""Characters of a number. Long numbers in base 60, which YAML has, take long to compute."""

ENDLESS = "it nests without end"

UNITS = {"!degrees": np.pi / 180.0, "!radians": 1.0, "!meters": 1.0, "!millimeters": 0.001}
"""Tags that xacro and the descriptions of ROS put before a number, in rad or m."""

NUMBERS = ("tag:yaml.org,2002:int", "tag:yaml.org,2002:float")

# YAML 1.1 takes 1e-3 for a text because it has no point; ROS's own parser and YAML 1.2 take it for a number.
_EXPONENT = re.compile(r"[-+]?[0-9][0-9_]*[eE][-+]?[0-9]+")


def parse_yaml(text: str, file: Path, most: int = MAX_NODES) -> Any:
    """Mappings, lists, texts and numbers of one YAML document of at most that many values.

    DescriptionError `limits-unusable` for anything else.
    """
    import yaml

    try:
        return yaml.load(text, Loader=_loader(yaml, most))
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        place = Place(str(file), mark.line + 1 if mark else None)
        raise refusal("limits-unusable", place, f"not usable YAML: {_words(error)}") from error
    except (RecursionError, ValueError, OverflowError) as error:
        what = ENDLESS if isinstance(error, RecursionError) else str(error)
        raise refusal("limits-unusable", Place(str(file)), f"not usable YAML: {what}") from error


def _words(error: Any) -> str:
    words = " ".join(str(getattr(error, "problem", None) or error).split())
    return ENDLESS if "nesting depth" in words else words  # newer libyamls have a limit of their own


def _bad_number(node: Any) -> str:
    """Why a number is refused. Empty for usual numbers and other values."""
    if node.tag not in NUMBERS:
        return ""
    if len(node.value) > MAX_NUMBER:
        return f"a number of more than {MAX_NUMBER} characters"
    return f"{node.value} is a number in base 60; write it in base 10" if ":" in node.value else ""


def safe_loader(yaml: Any) -> Any:
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


def _loader(yaml: Any, most: int) -> Any:
    """A separate safe loader, because tags on PyYAML's loader would hold for the whole process."""

    class Loader(safe_loader(yaml)):  # type: ignore[misc,unused-ignore]
        # xacro registers tags of its own on PyYAML's, and evaluates what stands behind them.
        yaml_constructors = {  # noqa: RUF012
            tag: made for tag, made in yaml.SafeLoader.yaml_constructors.items() if not str(tag).startswith("!")
        }

        def __init__(self, stream: str) -> None:
            super().__init__(stream)
            self.count = 0
            self.sizes: dict[int, int] = {}

        def compose_node(self, parent: Any, index: Any) -> Any:
            mark = self.peek_event().start_mark
            alias, before = self.check_event(yaml.events.AliasEvent), self.count
            node = super().compose_node(parent, index)
            if alias and id(node) not in self.sizes:
                raise yaml.constructor.ConstructorError(None, None, "an alias inside its own value", mark)
            self.count += self.sizes[id(node)] if alias else 1
            self.sizes.setdefault(id(node), self.count - before)
            problem = f"more than {most} values" if self.count > most else _bad_number(node)
            if problem:
                raise yaml.constructor.ConstructorError(None, None, problem, mark)
            return node

        def compose_mapping_node(self, anchor: Any) -> Any:
            node = super().compose_mapping_node(anchor)
            keys = Counter(key.value for key, _ in node.value if isinstance(key.value, str))
            twice = next((key for key, times in keys.items() if times > 1), None)
            if twice is not None:
                raise yaml.constructor.ConstructorError(None, None, f"{twice!r} stands there twice", node.start_mark)
            return node

    def with_unit(loader: Any, tag: str, node: Any) -> float:
        if "!" + tag not in UNITS:
            problem = f"the tag !{tag} is unknown; allowed: {', '.join(UNITS)}"
            raise yaml.constructor.ConstructorError(None, None, problem, node.start_mark)
        return float(loader.construct_scalar(node)) * UNITS["!" + tag]

    Loader.add_multi_constructor("!", with_unit)
    Loader.add_implicit_resolver("tag:yaml.org,2002:float", _EXPONENT, list("-+0123456789"))
    return Loader
