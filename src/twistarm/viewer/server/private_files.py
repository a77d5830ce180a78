"""Files that this user alone can read, kept from one run to the next in the system's folder for such things."""

from __future__ import annotations

import os
import stat
import sys
from itertools import count
from pathlib import Path

from ...support.errors import InputError
from ...support.files import write_whole


def state_folder() -> Path:
    """Where programs keep their state: $XDG_STATE_HOME, else ~/.local/state; on macOS ~/Library/Application Support.

    Raises InputError where this user has no home folder.
    """
    given = os.environ.get("XDG_STATE_HOME", "")
    if os.path.isabs(given) and sys.platform != "darwin":  # a relative one is ignored, says the XDG standard
        return Path(given) / "twistarm"
    home = os.path.expanduser("~")
    if not os.path.isabs(home):
        raise InputError("this user has no home folder")
    below = ("Library", "Application Support") if sys.platform == "darwin" else (".local", "state")
    return Path(home, *below, "twistarm")


class PrivateFolder:
    """The folder, made for this user alone where it does not exist; the files in it are read by their names.

    What somebody else may have put there is not used: neither the folder nor a file may belong to another user or be a
    link, and no file may be open to others. Raises InputError, in one line, where that is so or the disk refuses.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            path.mkdir(mode=0o700, parents=True, exist_ok=True)
            found = path.lstat()
            if not stat.S_ISDIR(found.st_mode) or found.st_uid != os.geteuid():
                raise InputError(f"{path} is no folder of this user's own; move it away")
            if found.st_mode & 0o077:
                path.chmod(0o700)
        except OSError as error:
            raise InputError(f"{path} cannot be used: {error.strerror or error}") from error

    def read(self, name: str, most: int) -> bytes | None:
        """The content of a file of at most `most` bytes; None where there is no such file."""
        path = self.path / name
        try:
            # O_NONBLOCK: to open a pipe would wait for whoever writes to it.
            with open(os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK), "rb") as file:
                found = os.fstat(file.fileno())
                if not stat.S_ISREG(found.st_mode):
                    raise InputError(f"{path} is no file")
                if found.st_uid != os.geteuid() or found.st_mode & 0o077:
                    raise InputError(f"{path} is not this user's alone")
                if found.st_size > most:
                    raise InputError(f"{path} has {found.st_size} bytes; at most {most}")
                return file.read(most)
        except FileNotFoundError:
            return None
        except OSError as error:
            raise InputError(f"{path} cannot be read: {error.strerror or error}") from error

    def write(self, name: str, content: str) -> None:
        """Put a file there, whole or not at all; a link of that name gives way to it."""
        path = self.path / name
        try:
            if path.is_symlink():
                path.unlink()
        except OSError as error:
            raise InputError(f"{path} cannot be replaced: {error.strerror or error}") from error
        write_whole(path, content, private=True)

    def set_aside(self, name: str) -> Path:
        """Give the file another name, which is free, and at which it can be looked at."""
        path = self.path / name
        names = (path.with_suffix(f".old{'' if k == 1 else k}{path.suffix}") for k in count(1))
        try:
            return path.replace(next(free for free in names if not os.path.lexists(free)))
        except OSError as error:
            raise InputError(f"{path} cannot be renamed: {error.strerror or error}") from error
