"""TOML and YAML as plain data. See `support.fields` for the entries."""

from __future__ import annotations

import json
import re
import sys
from collections import Counter
from pathlib import Path
from typing import Any

from ...support.errors import DescriptionError
from ...support.units import factor
from ..document import read_text
from ..findings import Place, refusal

MAX_BYTES = 64_000  # An arm.toml has some 5 kB.


def unusable(path: Path, what: str, remedy: str = "") -> DescriptionError:
    """The error for an unusable file or entry."""
    return refusal("companion-unusable", Place(str(path)), what, remedy)


def parse_toml(path: Path, what: str = "an arm.toml") -> dict[str, Any]:
    """The content of the file. DescriptionError, which names `what` it should be, if it is not TOML or too large."""
    return toml_content(read_text(path, MAX_BYTES), path, what)


def toml_content(text: str, path: Path, what: str = "an arm.toml") -> dict[str, Any]:
    """The content of such a text."""
    if sys.version_info >= (3, 11):
        import tomllib
    else:
        import tomli as tomllib

    try:
        return tomllib.loads(text)
    except (RecursionError, ValueError) as error:  # TOMLDecodeError is a ValueError; so is that for too many digits
        raise unusable(path, f"not valid TOML: {error}", f"correct it there, or is it {what}?") from error


def toml_key(name: str) -> str:
    """A key: bare where TOML allows that, else quoted."""
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else toml_text(name)


def toml_text(text: str) -> str:
    """A TOML string; JSON's escapes are TOML's, except delete."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


# Tags that the joint_limits.yaml of ROS put before a number.
TAGS = {"degrees": factor("deg", "rad"), "radians": 1.0}

# YAML 1.1 takes 1e-3 for a text because it has no point; ROS's own parser and YAML 1.2 take it for a number.
_EXPONENT = re.compile(r"[-+]?[0-9][0-9_]*[eE][-+]?[0-9]+")


def parse_yaml(text: str, file: Path) -> Any:
    """Mappings, lists, texts and numbers of one YAML document, in which no mapping has a key twice.

    It may end with the separator of a next document, as what `ros2 topic echo` prints does.

    DescriptionError `companion-unusable`, with the line, for anything else.
    """
    import yaml

    # On libyaml's parser, where PyYAML has it, which takes a quarter of the time.
    base: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)

    class Loader(base):  # type: ignore[misc] # a class of our own: tags on PyYAML's would hold for the whole process
        def construct_mapping(self, node: Any, deep: bool = False) -> Any:
            keys = Counter(key.value for key, _ in node.value if isinstance(key.value, str))
            if twice := [key for key, count in keys.items() if count > 1]:
                raise yaml.constructor.ConstructorError(None, None, f"{twice[0]!r} is there twice", node.start_mark)
            return super().construct_mapping(node, deep)

    def with_unit(loader: Any, tag: str, node: Any) -> float:
        if tag not in TAGS:
            problem = f"the tag !{tag} is unknown; allowed: !{', !'.join(TAGS)}"
            raise yaml.constructor.ConstructorError(None, None, problem, node.start_mark)
        return float(loader.construct_scalar(node)) * TAGS[tag]

    Loader.add_multi_constructor("!", with_unit)
    Loader.add_implicit_resolver("tag:yaml.org,2002:float", _EXPONENT, list("-+0123456789"))
    try:
        return yaml.load(text.rstrip().removesuffix("\n---"), Loader=Loader)
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        what = " ".join(str(getattr(error, "problem", None) or error).split())
        place = Place(str(file), mark.line + 1 if mark else None)
        raise refusal("companion-unusable", place, f"not usable YAML: {what}") from error
    except (RecursionError, ValueError, OverflowError) as error:
        raise refusal("companion-unusable", Place(str(file)), f"not usable YAML: {error}") from error
