"""What mutants are made of: our own robots, the catalogue's arms, and real models where they are at hand."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path, PurePath
from typing import Any

from twistarm.description.catalog import model_arms, model_entry, own_arms, robots_dir

TEXTS = (".urdf", ".xacro", ".toml", ".srdf", ".yaml", ".xml")


@dataclass(frozen=True)
class Source:
    """A folder of text files, the one that is loaded, those that are mutated, and how it is loaded.

    `beside`: arguments that are files of the folder ({"srdf": "config/arm.srdf"}); `alone`: nothing else is read.
    """

    name: str
    folder: Path
    file: str
    mutated: tuple[str, ...]
    arguments: Mapping[str, Any] = field(default_factory=dict)
    beside: Mapping[str, str] = field(default_factory=dict)
    alone: bool = False

    def texts(self) -> dict[str, bytes]:
        """Every text file of the folder by its relative path."""
        if self.alone:
            return {self.file: (self.folder / self.file).read_bytes()}
        files = sorted(path for path in self.folder.rglob("*") if path.suffix in TEXTS and path.is_file())
        return {str(path.relative_to(self.folder)): path.read_bytes() for path in files}

    def packages(self) -> dict[str, str]:
        """The packages in the folder by the name in their package.xml, relative to it."""
        manifests = [file for file in self.texts() if PurePath(file).name == "package.xml"]
        names = {file: ET.fromstring(self.texts()[file]).findtext("name", "").strip() for file in manifests}
        return {name: str(PurePath(file).parent) for file, name in names.items()}


def seed_sources() -> list[Source]:
    """A short arm with everything that is read: each kind of joint, SRDF, joint_limits.yaml, macros, YAML, arm.toml."""
    folder = Path(__file__).parent / "seeds"
    beside = {"srdf": "seed.srdf", "limits": "joint_limits.yaml"}
    return [
        Source("seed", folder, "seed.urdf", ("seed.urdf",), {"tip": "tool0"}),
        Source("seed with files beside", folder, "seed.urdf", ("seed.srdf", "joint_limits.yaml"), beside=beside),
        Source("seed arm.toml", folder, "arm.toml", ("arm.toml", "arm.toml", "seed.srdf", "seed.urdf")),
        Source("seed xacro", folder, "seed.xacro", ("seed.xacro", "parts.xacro", "values.yaml"), {"tip": "tool0"}),
    ]


def own_sources() -> list[Source]:
    """Each of our robots as description and as arm.toml."""
    sources = []
    for name in own_arms():
        folder = robots_dir() / name
        descriptions = tuple(sorted(path.name for path in folder.iterdir() if path.suffix in (".urdf", ".xacro")))
        main = next(file for file in descriptions if file.startswith(f"{name}.urdf"))
        sources.append(Source(name, folder, main, descriptions, {"tip": _tip(folder / "arm.toml")}))
        sources.append(Source(f"{name} arm.toml", folder, "arm.toml", ("arm.toml", "arm.toml", "arm.toml", main)))
    return sources


def _tip(arm_file: Path) -> str | None:
    lines = [line.split("=") for line in arm_file.read_text("utf-8").splitlines() if line.startswith("tip")]
    return lines[0][1].strip().strip('"') if lines else None


def catalogue_sources() -> list[Source]:
    """The arms of the example-robot-data wheel."""
    sources = []
    for name in model_arms():
        entry = model_entry(name)
        assert entry is not None
        arguments, file = {"base": entry.base, "tip": entry.tip}, entry.file
        sources.append(Source(name, file.parent, file.name, (file.name,), arguments, alone=True))
    return sources


_WALLII = "urc_arm_moveit_config/config"

_REAL = (
    ("robojackets_slider_arm/cartesian_controller_simulation", "urdf/arm_gazebo.urdf.xacro", (), {"tip": "tool0"}),
    ("robojackets_walliiarmv3", "urc_gazebo/urdf/WalliiArmV3.urdf", (), {"tip": "claw"}),
    ("robojackets_walli_v2_block/urdf/walli_arm_v2_block", "robot.urdf", (), {"tip": "ee"}),
    (
        "ur_description",
        "urdf/ur.urdf.xacro",
        ("urdf/ur_macro.xacro", "urdf/inc/ur_common.xacro", "config/ur5e/default_kinematics.yaml"),
        {"tip": "tool0", "xacro_args": {"name": "ur", "ur_type": "ur5e"}},
    ),
    ("so101", "so101_new_calib.urdf", (), {"tip": "gripper_frame_link"}),
    (
        "annin_ar4_description",
        "urdf/ar.urdf.xacro",
        ("urdf/ar_macro.xacro", "config/mk3.yaml"),
        {"tip": "ee_link", "xacro_args": {"ar_model": "mk3"}},
    ),
    (
        "kortex_description",
        "robots/gen3.xacro",
        ("robots/kortex_robot.xacro", "arms/gen3/7dof/urdf/gen3_macro.xacro"),
        {"tip": "tool_frame", "xacro_args": {"dof": "7"}},
    ),
    ("kortex_description", "robots/gen3_lite.urdf", (), {"tip": "tool_frame"}),
)
"""Under the folder of real models: folder, file, further files that are mutated, arguments."""


def real_sources(models: Path) -> list[Source]:
    """The real arms in the folder that TWISTARM_MODELS names."""
    beside = {"srdf": f"{_WALLII}/WalliiArmV3.srdf", "limits": f"{_WALLII}/joint_limits.yaml"}
    wallii, file = models / "robojackets_walliiarmv3", "urc_gazebo/urdf/WalliiArmV3.urdf"
    return [
        *(
            Source(f"{folder}/{file}", models / folder, file, (file, *others), arguments)
            for folder, file, others, arguments in _REAL
        ),
        Source("WalliiArmV3 with files beside", wallii, file, tuple(beside.values()), {"tip": "claw"}, beside),
    ]
