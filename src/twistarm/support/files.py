"""Reading a regular file within bounds, and writing one whole or not at all."""

from __future__ import annotations

import errno
import os
import re
import shutil
import stat
from collections.abc import Iterable, Mapping
from contextlib import suppress
from itertools import islice
from pathlib import Path
from typing import BinaryIO

from .errors import InputError, closest, quote

# Names, in any letters, of what a team wrote itself: no output takes its place unasked.
DESCRIPTIONS = (".urdf", ".xacro", ".srdf", ".sdf", ".xml", ".toml", ".yaml", ".yml")

WRITTEN_YAML = "# written by twistarm"
# What YAML of ours begins with, and URDF ends with: it is no team's own text and may be replaced.
WRITTEN_XML = "<!-- written by twistarm -->"

# How files begin that often go by another's name: what each is, and what to do. `404: Not Found` is a page too.
KINDS = {
    rb"(?i)\s*(<!doctype\s+html|<html\b|\d{3}:? [a-z ]+\s*\Z)": (
        "a web page, as a failed download leaves one", "download it again, raw",
    ),
    rb"version https://git-lfs": ("a Git LFS pointer", "run git lfs pull in the repository it comes from"),
    rb"PK[\3\5]": ("a ZIP archive", "unpack it"),
    rb"\x1f\x8b|BZh|\xfd7zXZ|7z\xbc\xaf|Rar!|\x28\xb5\x2f\xfd": ("a packed file", "unpack it"),
    rb"\x89PNG|\xff\xd8\xff|GIF8": ("a picture", "put the file there that was meant"),
    rb"%PDF": ("a PDF", "put the file there that was meant"),
}  # fmt: skip
LOOKED_AT = 1_000  # Bytes at the beginning of a file that show its kind.

NO_SUCH_FILE, FOLDER = "no such file", "a folder"
MOST_COMPARED = 2000  # Files of a folder that are compared with a name: they take 10 ms.

# How a file is opened to read, without waiting for a writer. A system has only some of these flags.
READING = sum(getattr(os, name, 0) for name in ("O_RDONLY", "O_NONBLOCK", "O_NOCTTY", "O_CLOEXEC", "O_BINARY"))
TEMPORARY = ".twistarm.part"  # How the names of our temporary files end.


def is_file(path: Path) -> bool:
    """Whether `path` is a visible regular file. False for a too long or malformed name."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def what_is_at(path: Path) -> str:
    """What is at `path` instead of a regular file. Empty for one."""
    try:
        mode = os.stat(path).st_mode
    except ValueError as error:
        return f"no usable path ({error})"
    except OSError as error:
        nothing = error.errno in (errno.ENOENT, errno.ENOTDIR)
        return NO_SUCH_FILE if nothing else f"no usable path ({error.strerror or error})"
    return FOLDER if stat.S_ISDIR(mode) else "" if stat.S_ISREG(mode) else "not a regular file"


def why_no_file(path: Path, error: Exception | None = None) -> str:
    """Why `path` cannot be read: `no such file; closest: 'arm.urdf'`. Of a regular file it is the `error`, if any."""
    what = what_is_at(path)
    if what == NO_SUCH_FILE:
        return what + closest_beside(path)
    return what or str(getattr(error, "strerror", None) or error or "")


def closest_beside(path: Path) -> str:
    """The names of files in the folder of `path` that are like its own, as `closest`."""
    with suppress(OSError):
        return closest(path.name, [other.name for other in islice(path.parent.iterdir(), MOST_COMPARED)])
    return ""


def open_regular(path: str | os.PathLike[str]) -> BinaryIO:
    """The regular file at `path`, opened to read, links followed.

    It is opened first and examined then, so that a FIFO or a device neither blocks nor is read. Raises OSError, its
    `strerror` in words, if no regular file can be opened.
    """
    descriptor = os.open(path, READING)
    try:
        if not stat.S_ISREG(os.fstat(descriptor).st_mode):
            raise OSError(errno.EINVAL, "it is no regular file", os.fspath(path))
        return open(descriptor, "rb")
    except BaseException:
        os.close(descriptor)
        raise


def read_bounded(path: str | os.PathLike[str], most: int) -> bytes:
    """The content of the regular file at `path`. Raises OSError as `open_regular`, with EFBIG above `most` bytes."""
    with open_regular(path) as file:
        size = os.fstat(file.fileno()).st_size
        data = b"" if size > most else file.read(most + 1)
        size = max(len(data), size)
    if size > most:
        raise OSError(errno.EFBIG, f"it has {size:,} bytes; at most {most:,} are read", os.fspath(path))
    return data


def kind_of(data: bytes, kinds: Mapping[bytes, tuple[str, str]] = KINDS) -> tuple[str, str] | None:
    """What the file is by its first bytes, and what to do about it. None if it is none of these `kinds`."""
    return next((kind for start, kind in kinds.items() if re.match(start, data[:LOOKED_AT])), None)


def stamp(path: Path) -> tuple[int, ...] | None:
    """The time of change, length and inode of a file, which change with its content. None if there is no file.

    The inode changes where an editor replaces the file.
    """
    try:
        found = path.stat()
    except (OSError, ValueError):
        return None
    return found.st_mtime_ns, found.st_size, found.st_ino


def as_path(path: str | os.PathLike[str]) -> Path:
    """The path with a leading `~` resolved, if the user exists. Raises InputError for an invalid path."""
    try:
        given = Path(path)
    except TypeError as error:
        raise InputError(f"a path must be a string or a Path; got {quote(path)}") from error
    try:
        return given.expanduser()
    except RuntimeError:
        return given


def as_paths(paths: Iterable[str | os.PathLike[str]], name: str) -> tuple[Path, ...]:
    """One path or several, each `as_path`. InputError for what is neither."""
    try:
        return tuple(map(as_path, [paths] if isinstance(paths, (str, os.PathLike)) else paths))
    except TypeError as error:
        raise InputError(f"{name} must be a path or several; got {quote(paths)}") from error


def write_whole(path: str | os.PathLike[str], content: str | bytes | Path, *, over_description: bool = False) -> Path:
    """Write `content` to `path` so that a reader sees the old file or the new one, never a part.

    Text is written as UTF-8, with its line ends unchanged. A Path is a file in the same file system, which is moved.
    The content goes into a temporary file in the same folder. This takes the name in one step (POSIX `rename`). On any
    error it is removed, and the old file stays. A killed process leaves it, under a name that ends with
    `.twistarm.part`. A link is followed. An existing file keeps its permissions. Returns the path.

    Raises InputError for a folder that is missing or not writable, or if `path` is a folder or a device. A
    description (`DESCRIPTIONS`) is replaced only with `over_description`.
    """
    target = writable(path, over_description=over_description)
    data = content.encode("utf-8") if isinstance(content, str) else content
    temporary = target.with_name(f".{target.name[:40]}.{os.urandom(6).hex()}{TEMPORARY}")
    try:
        if isinstance(data, Path):
            os.rename(data, temporary)
        with open(temporary, "ab" if isinstance(data, Path) else "xb") as file:
            if target.exists():
                shutil.copymode(target, temporary)
            file.write(b"" if isinstance(data, Path) else data)
            file.flush()
            os.fsync(file.fileno())
            os.replace(temporary, target)
    except BaseException as error:
        temporary.unlink(missing_ok=True)
        if isinstance(error, OSError):
            raise InputError(f"cannot write {target}: {error.strerror or error}") from error
        raise
    return target


def write_folder(folder: str | os.PathLike[str], contents: Mapping[str, str | bytes]) -> Path:
    """Write files by name into `folder`. A new folder appears whole.

    In a folder that exists, nothing changes before all are written. Then files of the same names are replaced, each in
    one step in the order given. Others stay. Returns the folder, links
    followed. Raises InputError as `write_whole`.
    """
    target = writable(folder, folder=True)
    new = not target.exists()
    temporary = (target.parent if new else target) / f".{target.name[:40]}.{os.urandom(6).hex()}{TEMPORARY}"
    try:
        if not new:
            for name in contents:
                writable(target / name)
        temporary.mkdir()
        for name, content in contents.items():
            write_whole(temporary / name, content)
        if new:
            temporary.rename(target)
        else:
            for name in contents:
                os.replace(temporary / name, target / name)
            temporary.rmdir()
    except BaseException as error:
        shutil.rmtree(temporary, ignore_errors=True)
        if isinstance(error, OSError):
            raise InputError(f"cannot write into {target}: {error.strerror or error}") from error
        raise
    return target


def writable(path: str | os.PathLike[str], *, over_description: bool = False, folder: bool = False) -> Path:
    """The file of `path`, links followed. Raises InputError if it cannot be replaced as a whole.

    With `folder` it is a folder to write into, which need not exist.
    """
    try:
        target = Path(os.path.realpath(os.fspath(path)))
        exists = target.exists()
    except (TypeError, ValueError) as error:
        raise InputError(f"the path of a file to write must be a string or a Path; got {quote(path)}") from error
    except OSError as error:
        raise InputError(f"cannot write {str(path)[:60]}…: {error.strerror or error}") from error
    above, why = target.parent, ""
    if not above.is_dir():
        why = (
            f"{above} is a file; give a folder"
            if above.is_file()
            else f"the folder {above} does not exist; create it first"
        )
    elif folder:
        why = "it is a file; give a folder" if exists and not target.is_dir() else ""
    elif exists and not target.is_file():
        why = "it is a folder" if target.is_dir() else "it is not a regular file and cannot be replaced as a whole"
    elif exists and not over_description and _is_description(target):
        why = f"no output replaces a *{target.suffix} that twistarm did not write; give another name, or delete it"
    if why:
        raise InputError(f"cannot write {target}: {why}")
    return target


def _is_description(file: Path) -> bool:
    """Whether it is a description by its name, and no YAML or URDF of ours."""
    if file.suffix.lower() not in DESCRIPTIONS:
        return False
    try:
        with open_regular(file) as opened:
            start = opened.read(len(WRITTEN_YAML))
            opened.seek(max(0, opened.seek(0, os.SEEK_END) - 2 * len(WRITTEN_XML)))
            return start != WRITTEN_YAML.encode() and not opened.read().rstrip().endswith(WRITTEN_XML.encode())
    except OSError:
        return True
