"""Poses that a page writes into the arm's own arm.toml."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import partial
from pathlib import Path

from ...arm.arm import Arm
from ...arm.loading.load import load_arm
from ...description.companions.arm_file import read_arm_file
from ...description.companions.data_files import write_pose
from ...support.checks import Array
from ...support.errors import InputError
from ...support.files import as_path, is_file
from ..protocol.jobs import Job, Progress
from ..protocol.messages import Message
from .arm_data import checked_theta
from .show import Part, Route, Show


class Keeping(Part):
    """A part that writes poses once the server offers the arm's file. It does so for pages of this computer only."""

    def __init__(self) -> None:
        self._message: Message = {"type": "keeping", "file": None, "names": []}
        self._file: Path | None = None
        self.routes = {"keep_pose": Route(self._keep)}

    def offer(self, arm: Arm) -> None:
        """Let pages write into the arm.toml that `arm` was loaded from, if there is one."""
        path = as_path(arm.source)
        if path.suffix == ".toml" and is_file(path):
            self._file = path.resolve()
            self._tell(read_arm_file(self._file).poses)

    def _tell(self, names: Iterable[str]) -> None:
        self._message = {"type": "keeping", "file": str(self._file), "names": list(names)}

    def _keep(self, show: Show, now: float, name: str, theta: list[float], replace: bool) -> Job:
        """Write a pose in a thread. InputError if no file is offered."""
        if self._file is None:
            raise InputError("no arm.toml is written from this page: copy the lines into it")
        if not name.strip():
            raise InputError("a pose needs a name, such as stowed")
        work = partial(_written, self._file, show.arm, name.strip(), checked_theta(show.arm, theta), replace)
        return Job("keep_pose", "writing the pose", work, self._tell)

    def messages(self, show: Show) -> Iterator[Message]:
        """The file that is offered, and the names of its poses."""
        yield self._message


def _written(file: Path, arm: Arm, name: str, theta: Array, replace: bool, progress: Progress) -> list[str]:
    """Write the pose if the arm of the file alone takes it. Return the names of all poses."""
    alone = load_arm(file)
    if alone.joint_names != arm.joint_names or not alone.limits.contains(theta):
        raise InputError(f"the arm of {file} alone has other joints or limits, so it has no such pose; copy the lines")
    write_pose(file, name, arm.theta_to_dict(theta), replace=replace)
    return list(read_arm_file(file).poses)
