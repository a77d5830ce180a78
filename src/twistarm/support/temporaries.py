"""Temporary files beside what they are to replace, and what becomes of those that a killed process left."""

from __future__ import annotations

import fcntl
import os
import re
import stat
import time
from contextlib import suppress
from itertools import islice
from pathlib import Path

TEMPORARY = ".twistarm.part"
"""How the names of our temporary files end."""

LEFT_AFTER = 60.0
"""Seconds after which a temporary file that no process holds was left behind."""

MOST_ENTRIES = 10_000
"""Of a folder, that are looked through for such files."""

_TEMPORARY = re.compile(rf"\..+\.[0-9a-f]{{12}}{re.escape(TEMPORARY)}", re.DOTALL)


def replace_whole(target: Path, data: bytes) -> None:
    """Put `data` at `target` in one step; OSError where that fails, and then nothing has changed.

    The temporary file in the same folder is for this user alone until it has the group and the permissions of what it
    replaces, and that before its first byte: for whom the content is not, that file is not either.
    """
    _sweep(target.parent)
    found = target.stat() if target.exists() else None
    mode = 0o666 if found is None else 0o600
    temporary = target.with_name(f".{target.name[:40]}.{os.urandom(6).hex()}{TEMPORARY}")
    try:
        with open(temporary, "xb", opener=lambda name, flags: os.open(name, flags, mode)) as file:
            with suppress(OSError):  # some network drives know no locks
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if found is not None:
                _give(file.fileno(), found)
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
            os.replace(temporary, target)
    except BaseException:
        with suppress(OSError):
            os.unlink(temporary)
        raise


def _give(descriptor: int, found: os.stat_result) -> None:
    """Give a file the group and the permissions of another, or none for the group where it may not have that one."""
    mode = found.st_mode & 0o777
    try:
        os.fchown(descriptor, -1, found.st_gid)
    except OSError:
        mode &= ~0o070
    os.fchmod(descriptor, mode)


def _sweep(folder: Path) -> None:
    """Remove what `write_whole` left in the folder when it was killed: of this user, and held by no process any more.

    A process holds a lock on its temporary file, which the system lets go of with the process. Between the file's
    making and its lock lies a moment, for which its age stands.
    """
    with suppress(OSError), os.scandir(folder) as entries:
        for entry in islice(entries, MOST_ENTRIES):
            if _TEMPORARY.fullmatch(entry.name):
                with suppress(OSError):
                    _remove_left(entry.path)


def _remove_left(path: str) -> None:
    descriptor = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)
    try:
        found = os.fstat(descriptor)
        old = time.time() - found.st_mtime > LEFT_AFTER
        if stat.S_ISREG(found.st_mode) and found.st_uid == os.geteuid() and old:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            os.unlink(path)
    finally:
        os.close(descriptor)
