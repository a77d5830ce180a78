"""Redaction of paths: shared texts do not reveal folders of this machine."""

from __future__ import annotations

import os
import re
from contextlib import suppress
from pathlib import Path

_ABSOLUTE = re.compile(r"(?<![\w.:/~)}>-])(?:file://(?:localhost)?)?/(?:[^\s/'\"<>|,;()]+/)+([^\s/'\"<>|,;()]*)")


def without_places(text: str, *files: Path | None) -> str:
    """`text` with file paths reduced to the name, or to the path from a known folder.

    These are the folders above `files`, the home folder and the working one. Any other absolute path is recognised by
    its slashes.
    """
    for folder in _folders(files):
        text = re.sub(rf"(?<![\w.:~)}}>-])(?:file://(?:localhost)?)?{re.escape(folder)}(?:/|(?![\w.-]))", "", text)
    return _ABSOLUTE.sub(r"\1", text)


def _folders(files: tuple[Path | None, ...]) -> list[str]:
    """The longest first, the root left out."""
    home = os.path.expanduser("~")  # as it is for a user that has none
    known = {Path(home), Path(os.path.realpath(home))} if os.path.isabs(home) else set()
    with suppress(OSError):  # the working folder was deleted
        known.add(Path.cwd())
    for file in files:
        if file is not None and file.is_absolute():
            known.update(file.parents)
    return sorted((str(folder) for folder in known if folder != Path(folder.anchor)), key=len, reverse=True)
