"""TOML read within bounds, and keys and texts of it written. See `support.fields` for the entries."""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path
from typing import Any

from ...support.errors import DescriptionError
from ..document import read_text
from ..findings import Place, refusal

MAX_BYTES, MAX_LINE = 64_000, 2_000
"""An arm.toml has some 5 kB. TOML's reader takes seconds for a dotted key that fills a longer line."""


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

    if max(map(len, text.splitlines()), default=0) > MAX_LINE:
        raise unusable(path, f"a line of more than {MAX_LINE:,} characters", f"break it; is it {what}?")
    try:
        return tomllib.loads(text)
    except RecursionError as error:
        raise unusable(path, "not valid TOML: it nests too deep", f"is it {what}?") from error
    except ValueError as error:  # TOMLDecodeError is one; so is Python's for an integer of too many digits
        raise unusable(path, f"not valid TOML: {error}", "correct it there") from error


def toml_key(name: str) -> str:
    """A key: bare where TOML allows that, else quoted."""
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else toml_text(name)


def toml_text(text: str) -> str:
    """A TOML string; JSON's escapes are TOML's, except delete."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
