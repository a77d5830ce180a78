"""Arms by name: those of twistarm, and those of the example-robot-data wheel."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from ..support.errors import missing_extra


class ModelsEntry(NamedTuple):
    """An arm of the example-robot-data wheel: its file, base and tip, and the folder of its packages."""

    file: Path
    base: str
    tip: str
    share: Path


_MODELS = {
    "panda": ("panda_description/urdf/panda.urdf", "panda_link0", "panda_hand_tcp"),
    "ur3": ("ur_description/urdf/ur3_robot.urdf", "base_link", "tool0"),
    "ur5": ("ur_description/urdf/ur5_robot.urdf", "base_link", "tool0"),
    "ur10": ("ur_description/urdf/ur10_robot.urdf", "base_link", "tool0"),
    "kinova": ("kinova_description/robots/kinova.urdf", "j2s6s200_link_base", "j2s6s200_end_effector"),
    "xarm7": ("xarm_description/urdf/xarm7.urdf", "link_base", "link_eef"),
    "z1": ("z1_description/urdf/z1.urdf", "link00", "gripperStator"),
    "so100": ("so_arm_description/urdf/so100.urdf", "base", "gripper"),
    "so101": ("so_arm_description/urdf/so101.urdf", "base_link", "gripper_frame_link"),
}
"""File, base and tip of each arm."""


def robots_dir() -> Path:
    """The folder of twistarm's arms: inside the installed package, or beside `src` in a checkout."""
    package = Path(__file__).resolve().parents[1]
    installed = package / "robots"
    return installed if installed.is_dir() else package.parents[1] / "robots"


def own_arms() -> tuple[str, ...]:
    """Names of the arms that come with twistarm."""
    return tuple(sorted(file.parent.name for file in robots_dir().glob("*/arm.toml")))


def model_arms() -> tuple[str, ...]:
    """Names of the arms of the example-robot-data wheel, also if it is not installed."""
    return tuple(_MODELS)


def own_arm_file(name: str) -> Path | None:
    """The arm.toml of an arm of twistarm, or None."""
    file = robots_dir() / name / "arm.toml"
    return file if name in own_arms() else None


def models_share() -> Path | None:
    """The folder `share` of the example-robot-data wheel. None if it is not installed."""
    from importlib.metadata import PackageNotFoundError, distribution

    try:
        wheel = distribution("example-robot-data")
    except PackageNotFoundError:
        return None
    share = Path(str(wheel.locate_file("cmeel.prefix/share")))
    return share if share.is_dir() else None


def model_entry(name: str) -> ModelsEntry | None:
    """The entry of an arm of the wheel, or None for another name. MissingExtraError without the wheel."""
    if name not in _MODELS:
        return None
    share = models_share()
    if share is None:
        raise missing_extra(f"the catalogue arm {name!r}", "example-robot-data", "models")
    file, base, tip = _MODELS[name]
    return ModelsEntry(share / "example-robot-data" / "robots" / file, base, tip, share)
