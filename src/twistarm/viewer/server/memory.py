"""Memory of a view at a fixed port: recorded poses and theta, as JSON in the state folder."""

from __future__ import annotations

import hashlib
import os
import sys
from collections.abc import Mapping
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np

from ...arm.arm import Arm
from ...support.errors import InputError, TwistarmError
from ...support.files import as_path, is_file, read_bounded, write_whole
from ...support.strict_json import LARGEST_MESSAGE, decoded, encode
from ..protocol.messages import CHECKS
from ..stage import Stage

ENTRIES = {"joints": "names", "poses": "poses", "theta": "numbers"}
"""Entries of a file and their types. A page's Load also accepts the file."""


class Memory:
    """The file of one port and one arm. `notes` says what could not be kept or taken; the view goes on without."""

    def __init__(self, port: int) -> None:
        self.notes: list[str] = []
        self._port = port
        self._path: Path | None = None
        self._kept = ""

    def recall(self, stage: Stage, stands: bool) -> None:
        """Give `stage` the stored poses for its arm and, unless `stands`, the stored theta.

        A file with unusable entries is set aside, not overwritten.
        """
        try:
            folder = state_folder()
            folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        except (OSError, InputError) as error:
            self.notes.append(f"the poses will not be kept: {error}")
            return
        self._path = folder / f"view-{self._port}-{_digest(stage.arm)}.json"
        if not os.path.lexists(self._path):
            return
        try:
            left = self._take(decoded(read_bounded(self._path, LARGEST_MESSAGE)), stage, stands)
        except (OSError, TwistarmError) as error:
            self.notes.append(f"the poses kept are not taken: {error}; {self._set_aside()}")
            return
        if left:
            more = f" and {len(left) - 1} more" if len(left) > 1 else ""
            self.notes.append(f"of the poses kept, one{more} does not fit: {left[0]}; {self._set_aside()}")

    def _take(self, given: Mapping[str, Any], stage: Stage, stands: bool) -> list[str]:
        """What was left of the file, in words."""
        joints, poses, theta = (CHECKS[kind](given.get(name), name) for name, kind in ENTRIES.items())
        if len(theta) != len(joints):
            raise InputError(f"theta must be {len(joints)} numbers; got {len(theta)}")
        left = stage.poses.take(joints, poses)
        if not stands:
            arm, stood = stage.arm, dict(zip(joints, theta, strict=True))
            stage.show(np.clip([stood[name] for name in arm.joint_names], arm.limits.lower, arm.limits.upper))
        return left

    def set_aside(self, stage: Stage) -> list[str]:
        """Set the file aside for its owner and begin another. Returns its place in words."""
        if self._path is None:
            return []
        try:
            self.keep(stage)  # it may have changed a moment ago
        except TwistarmError as error:
            return [f"the poses cannot be set aside: {error}"]
        return [self._set_aside()]

    def _set_aside(self) -> str:
        assert self._path is not None, "there is a file to set aside"
        names = (self._path.with_suffix(f".old{'' if k == 1 else k}.json") for k in count(1))
        self._kept = ""
        try:
            old = self._path.replace(next(free for free in names if not os.path.lexists(free)))
        except OSError as error:
            self._path = None
            return f"nothing will be kept: {error}"
        return f"what was kept is in {old} now"

    def keep(self, stage: Stage) -> None:
        """Write what there is to keep, if that is another than the last time. Raises InputError where it cannot."""
        poses = [pose.entry() for pose in stage.poses.poses]
        text = encode({"joints": stage.arm.joint_names, "poses": poses, "theta": stage.theta.tolist()})
        if self._path is not None and text != self._kept:
            write_whole(self._path, text)
            self._kept = text


def state_folder() -> Path:
    """The state folder: $XDG_STATE_HOME, else ~/.local/state; on macOS ~/Library/Application Support.

    Raises InputError if the user has no home folder.
    """
    given = os.environ.get("XDG_STATE_HOME", "")
    if os.path.isabs(given) and sys.platform != "darwin":  # a relative one is ignored, says the XDG standard
        return Path(given) / "twistarm"
    home = os.path.expanduser("~")
    if not os.path.isabs(home):
        raise InputError("this user has no home folder")
    below = ("Library", "Application Support") if sys.platform == "darwin" else (".local", "state")
    return Path(home, *below, "twistarm")


def _digest(arm: Arm) -> str:
    """What tells one arm at a port from another: its file, base and tip."""
    source = os.path.realpath(as_path(arm.source)) if is_file(as_path(arm.source)) else arm.source
    return hashlib.sha256(encode({"arm": [source, arm.base, arm.tip]}).encode()).hexdigest()[:16]
