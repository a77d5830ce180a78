"""State of a view at a fixed address, kept for its user from one run to the next: token, poses, theta."""

from __future__ import annotations

import hashlib
import os
import re
from collections.abc import Mapping
from typing import Any

import numpy as np

from ...model.arm import Arm
from ...support.errors import InputError, TwistarmError
from ...support.files import as_path, is_file
from ...support.strict_json import LARGEST_MESSAGE, decoded, encode, short
from ..protocol.messages import CHECKS
from ..stage import Stage
from .authentication import TOKEN, new_token
from .private_files import PrivateFolder, state_folder

ENTRIES = {"joints": "names", "poses": "poses", "theta": "numbers"}
"""Of a file, and what each must be: with the poses a page's Load takes the file too."""


class Memory:
    """Files of this user's for one address, `host` and `port`, and one arm: whoever has the port alone writes them.

    Nothing here raises: what cannot be kept or taken is said in `notes`, and the view goes on without.
    fresh: begin anew, with another token and no poses.
    """

    def __init__(self, host: str, port: int, fresh: bool = False) -> None:
        self.notes: list[str] = []
        self._fresh = fresh
        self._address = re.sub(r"[^\w.-]", "_", f"{host}-{port}")
        self._file = ""
        self._kept = ""
        self._folder: PrivateFolder | None = None
        try:
            self._folder = PrivateFolder(state_folder())
        except TwistarmError as error:
            self.notes.append(f"the address and the poses will not be kept: {error}")

    def token(self) -> str:
        """The token of this address: the one that it had the last time, or a new one, which is kept."""
        new, name = new_token(), f"{self._address}.token"
        if self._folder is None:
            return new
        try:
            known = None if self._fresh else self._known(self._folder, name)
            if known is None:
                self._folder.write(name, new)
            return known or new
        except TwistarmError as error:
            self.notes.append(f"the address is new and will not be kept: {error}")
            return new

    def _known(self, folder: PrivateFolder, name: str) -> str | None:
        """The token that was kept; None where there is none, or none that can be used."""
        try:
            text = (folder.read(name, most=1000) or b"").decode("ascii", "replace")
        except InputError as error:
            self.notes.append(f"the address is a new one: {error}")
            return None
        if text and not re.fullmatch(TOKEN, text):
            self.notes.append(f"the address is a new one: {folder.path / name} holds no token")
            return None
        return text or None

    def recall(self, stage: Stage, stands: bool) -> None:
        """Give `stage` the poses that were kept for its arm and, unless it `stands` where it was told to, the theta.

        A file of which something cannot be taken is set aside, not written over.
        """
        if self._folder is None:
            return
        self._file = f"{self._address}-{_digest(stage.arm)}.json"
        try:
            content = None if self._fresh else self._folder.read(self._file, LARGEST_MESSAGE)
            if content is None:
                return
            left = self._take(content, stage, stands)
            if left:
                more = f" and {len(left) - 1} more" if len(left) > 1 else ""
                aside = self._folder.set_aside(self._file)
                self.notes.append(f"of the poses kept, one{more} does not fit: {left[0]}; all are in {aside}")
        except TwistarmError as error:
            self.notes += [f"the poses kept are not taken: {error}", self._set_aside()]

    def _take(self, content: bytes, stage: Stage, stands: bool) -> list[str]:
        """What was left of the file, in words."""
        entries = _checked(decoded(content))
        joints, arm = entries["joints"], stage.arm
        left = stage.program.list.take(joints, entries["poses"])
        if not stands and sorted(joints) == sorted(arm.joint_names):
            theta = np.array([entries["theta"][joints.index(name)] for name in arm.joint_names])
            stage.show(np.clip(theta, arm.limits.lower, arm.limits.upper))
        self._kept = "" if left else self._text(stage)
        return left

    def set_aside(self, stage: Stage) -> list[str]:
        """Leave what there is to keep to whoever looks for it, and begin another file; where it is, in words."""
        if self._folder is None:
            return []
        try:
            self.keep(stage)  # it may have changed a moment ago
        except TwistarmError as error:
            return [f"the poses cannot be set aside: {error}"]
        return [self._set_aside()]

    def _set_aside(self) -> str:
        assert self._folder is not None, "there is a file to set aside"
        try:
            self._kept = ""
            return f"what was kept is in {self._folder.set_aside(self._file)} now"
        except TwistarmError as error:
            self._folder = None
            return f"nothing will be kept: {error}"

    def keep(self, stage: Stage) -> None:
        """Write what there is to keep, if that is another than the last time. Raises TwistarmError where it cannot."""
        text = self._text(stage)
        if self._folder is not None and text != self._kept:
            self._folder.write(self._file, text)
            self._kept = text

    @staticmethod
    def _text(stage: Stage) -> str:
        """As one line of JSON, in rad and m."""
        poses = [{"name": pose.name, "theta": pose.theta.tolist()} for pose in stage.program.list.poses]
        return encode({"joints": stage.arm.joint_names, "poses": poses, "theta": stage.theta.tolist()})


def _checked(entries: Mapping[str, Any]) -> dict[str, Any]:
    if set(entries) != set(ENTRIES):
        raise InputError(f"the file must hold {', '.join(ENTRIES)}; got {short(sorted(entries))}")
    checked = {name: CHECKS[kind](entries[name], name) for name, kind in ENTRIES.items()}
    if len(checked["theta"]) != len(checked["joints"]):
        raise InputError(f"theta must be {len(checked['joints'])} numbers; got {len(checked['theta'])}")
    return checked


def _digest(arm: Arm) -> str:
    """What tells one arm at an address from another: its file, base and tip."""
    source = os.path.realpath(as_path(arm.source)) if is_file(as_path(arm.source)) else arm.source
    return hashlib.sha256(encode({"arm": [source, arm.base, arm.tip]}).encode()).hexdigest()[:16]
