"""The folder of a site: known to be ours by a file in it, which also says of what each page was made."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable
from contextlib import suppress
from typing import Any

from ...support.errors import InputError, TwistarmError
from ...support.files import as_path, write_whole
from ...support.strict_json import decoded, encode

MARKER = "twistarm-guide.json"
"""The file that says that a folder is ours, and what we wrote there."""

MADE_BY = "twistarm guide"

SCENE = re.compile(r"(scene|meshes)_[0-9a-f]{12}\.(html|js)")
"""Names of scenes and of the meshes in them."""


class SiteFolder:
    """A folder that we may write into: new, empty, or one that we made before.

    Raises InputError for any other, and where the system refuses.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = as_path(path).absolute()
        try:
            if self.path.exists() and not self.path.is_dir():
                raise InputError(f"{self.path} is a file; -o takes a folder")
            if self.path.is_dir() and not self._ours() and any(self.path.iterdir()):
                raise InputError(
                    f"{self.path} holds something that the guide did not write (there is no {MARKER}); "
                    "give a new folder, or an empty one"
                )
            for folder in (self.path, self.path / "assets", self.path / "scenes"):
                folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(f"cannot write into {self.path}: {error.strerror or error}") from error
        self._record: dict[str, Any] = self._read()

    def _ours(self) -> bool:
        return (self.path / MARKER).is_file()

    def _read(self) -> dict[str, Any]:
        with suppress(OSError, TwistarmError, ValueError):
            found = decoded((self.path / MARKER).read_text("utf-8"))
            if isinstance(found.get("lessons"), dict) and isinstance(found.get("files"), list):
                return found
        return {"made by": MADE_BY, "lessons": {}, "files": []}

    def kept(self, lesson: str, key: str) -> dict[str, Any] | None:
        """What was kept of a lesson, if it was made of the same and its files are there."""
        entry = self._record["lessons"].get(lesson)
        if not isinstance(entry, dict) or entry.get("key") != key:
            return None
        files = [f"{lesson}.html", f"{lesson}.py", *entry.get("scenes", ())]
        return entry if all((self.path / str(name)).is_file() for name in files) else None

    def keep(self, lesson: str, entry: dict[str, Any]) -> None:
        """Note of what a lesson was made."""
        self._record["lessons"][lesson] = entry

    def write(self, name: str, text: str) -> None:
        """Write one of our files; it is noted before, so that it is known to be ours."""
        if name not in self._record["files"]:
            self._record["files"].append(name)
            self.save()
        path = self.path / name
        if not path.is_file() or path.read_text("utf-8", errors="replace") != text:
            write_whole(path, text)

    def save(self) -> None:
        """Write the record."""
        write_whole(self.path / MARKER, encode(self._record))

    def sweep(self, needed: Iterable[str]) -> None:
        """Remove pages and scenes that we wrote and that no page of now needs."""
        keep = set(needed)
        scenes = {f"scenes/{each.name}" for each in (self.path / "scenes").iterdir() if SCENE.fullmatch(each.name)}
        for name in (scenes | set(self._record["files"])) - keep:
            with suppress(OSError):
                (self.path / name).unlink()
        self._record["files"] = sorted(keep)
        self.save()
