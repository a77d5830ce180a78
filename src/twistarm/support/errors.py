"""The exceptions, and helpers to word a message: what was given, what is allowed, what to do. No private folders."""

from __future__ import annotations

import os
import re
import sys
import warnings
from collections.abc import Iterable
from contextlib import suppress
from difflib import get_close_matches
from pathlib import Path
from reprlib import Repr
from typing import Any

from .messages import Text

PACKAGE = os.path.dirname(os.path.dirname(__file__))  # The folder of this package.
# Characters of a value that a message repeats: it is the caller's own, and names or the first numbers are enough.
QUOTED = 80

_BRIEF = Repr()
_BRIEF.maxstring = _BRIEF.maxother = QUOTED

# Characters of a message: a description may hold names of any length, and a line has to be read.
LONGEST = 1800
# Characters of a name that is compared with others: that takes time by the product of their lengths.
LONGEST_COMPARED = 200


class TwistarmError(Exception):
    """The base of all errors that twistarm raises on purpose. Its text is one line that any terminal can show."""

    @property
    def message(self) -> str:
        """The text; a `Text` where it holds quantities or arguments, which another program can show in its words."""
        return one_line(self.args[0]) if self.args and isinstance(self.args[0], str) else super().__str__()

    def __str__(self) -> str:
        return str(self.message)


class InputError(TwistarmError, ValueError):
    """An argument has the wrong shape, value or meaning."""


class DescriptionError(TwistarmError):
    """A robot description cannot be used.

    `.findings` holds the same as a `Finding`, with all that was noticed before it.
    """

    def __init__(self, message: str, findings: tuple[Any, ...] = ()) -> None:
        super().__init__(message)
        self.findings = findings


class UnknownNameError(TwistarmError, LookupError):
    """A name that does not exist. The message offers the closest ones."""


class LimitError(TwistarmError):
    """A joint limit is violated, or one that is needed is not given."""


class NotConvergedError(TwistarmError):
    """`IKResult.require()` on a solution that did not converge. `.solution` is that solution."""

    def __init__(self, message: str, solution: Any = None) -> None:
        super().__init__(message)
        self.solution = solution


class NoClosedFormError(TwistarmError):
    """An arm has no closed form for a target. The message says what it lacks."""


class MissingExtraError(TwistarmError, ImportError):
    """An optional dependency is not installed. The message is the command that installs it."""


class RoundedPoseWarning(UserWarning):
    """A pose or rotation was rounded, as printed numbers are. The nearest rotation is used instead."""


class UnitsWarning(UserWarning):
    """Joint values that are plainly degrees, but count as radians."""


class ComparisonError(TwistarmError):
    """Two accounts of the same arm disagree."""


def warn(message: str, kind: type[Warning]) -> None:
    """Warn, and point at the line outside this package if Python can: from 3.12 on."""
    if sys.version_info >= (3, 12):
        warnings.warn(message, kind, skip_file_prefixes=(PACKAGE,))
    else:
        warnings.warn(message, kind, stacklevel=3)


def printable(text: str) -> str:
    """`text` with every character escaped that a terminal would obey or not show.

    These are line ends, C0 and C1, escapes, marks of direction and of no width, and half characters. A no-break space
    stays.
    """
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() or c == "\xa0" else c.encode("unicode_escape").decode("ascii") for c in text)


def one_line(text: str, longest: int = LONGEST) -> str:
    """`text` as `printable`, and the middle left out where it is too long. A `Text` that is both already stays one."""
    if len(text) > 2 * longest:  # of what is left out nothing is looked at
        text = text[:longest] + text[-longest:]
    line = printable(text)
    if len(line) <= longest:
        return line
    end = longest // 4
    return f"{line[: longest - end]} … {line[-end:]}"


def unknown_name(kind: str, given: Any, names: Iterable[str], *, within: str, listing: str) -> UnknownNameError:
    """`no frame 'tool_0' in ur5; closest: 'tool0' (12 frames: arm.frame_names)`."""
    what = "no {kind} {given} in {within}{near} ({listing})"
    near = closest(given, names)
    return UnknownNameError(Text(what, kind=kind, given=quote(given), within=within, near=near, listing=listing))


def closest(given: Any, names: Iterable[str]) -> str:
    """`; closest: 'a', 'b'`: names that contain the word, or else similar ones; nothing where there are none."""
    if not isinstance(given, str) or len(given) > LONGEST_COMPARED:
        return ""
    candidates = [name for name in names if len(name) <= LONGEST_COMPARED]
    folded = {name.casefold(): name for name in candidates}
    word = given.casefold()
    matches = [name for name in folded if len(word) > 2 and word in name][:3] or get_close_matches(word, folded, 3, 0.5)
    return "; closest: " + ", ".join(_quoted(folded[m]) for m in matches) if matches else ""


def listed(names: Iterable[str], limit: int = 12) -> str:
    """`'a', 'b', … (31 in all)`: a list that stays readable on one line."""
    every = list(names)
    text = ", ".join(_quoted(name) for name in every[:limit])
    return text if len(every) <= limit else f"{text}, … ({len(every)} in all)"


def quote(value: Any) -> str:
    """A given value for a message: on one line and short, with the shape only for a larger array."""
    shape = getattr(value, "shape", ())
    if isinstance(shape, tuple) and len(shape) > 1:
        return f"{type(value).__name__} of shape {shape}"
    try:
        return one_line(" ".join(_BRIEF.repr(value).split()), QUOTED)
    except Exception:  # what an object's own repr raises must not hide what is wrong
        return f"an object of type {type(value).__name__}"


def _quoted(name: str) -> str:
    return one_line(repr(name), 100)


def missing_extra(what: str, package: str, extra: str) -> MissingExtraError:
    """The error for an optional dependency, with the command that installs it."""
    return MissingExtraError(f"{what} needs {package}, which is not installed: pip install 'twistarm[{extra}]'")


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
