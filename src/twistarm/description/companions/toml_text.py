"""Keys and texts as TOML writes them."""

from __future__ import annotations

import json
import re


def toml_key(name: str) -> str:
    """A key: bare where TOML allows that, else quoted."""
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else toml_text(name)


def toml_text(text: str) -> str:
    """A TOML string; JSON's escapes are TOML's, except delete."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
