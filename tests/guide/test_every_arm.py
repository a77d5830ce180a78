"""The whole course on many arms: one of six joints, all that are bundled, and the real ones of `TWISTARM_MODELS`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from twistarm.description.catalog import own_arms
from twistarm.guide.building.building import build
from twistarm.guide.building.printing import pdf_of
from twistarm.guide.course import lessons

pytestmark = pytest.mark.slow

REAL: dict[str, dict[str, Any]] = {
    "robojackets_slider_arm/cartesian_controller_simulation/urdf/arm_gazebo.urdf.xacro": {"tip": "tool0"},
    "robojackets_walliiarmv3/urc_gazebo/urdf/WalliiArmV3.urdf": {"tip": "claw"},
    "robojackets_walli_v2_block/urdf/walli_arm_v2_block/robot.urdf": {"tip": "ee"},
    "ur_description/urdf/ur.urdf.xacro": {"tip": "tool0", "xacro_args": {"name": "ur", "ur_type": "ur5e"}},
    "so101/so101_new_calib.urdf": {"tip": "gripper_frame_link"},
    "annin_ar4_description/urdf/ar.urdf.xacro": {"tip": "ee_link", "xacro_args": {"ar_model": "mk3"}},
    "kortex_description/robots/gen3.xacro": {"tip": "tool_frame", "xacro_args": {"dof": "7"}},
    "kortex_description/robots/gen3_lite.urdf": {"tip": "tool_frame"},
}


@pytest.mark.parametrize("name", own_arms())
def test_the_course_on_every_bundled_arm(name: str, tmp_path: Path) -> None:
    made = build(tmp_path / "site", {"source": name})
    assert made.failed == ()
    assert made.run == lessons()


@pytest.mark.parametrize("file", REAL)
def test_the_course_on_every_real_arm(file: str, models: Path, tmp_path: Path) -> None:
    made = build(tmp_path / "site", {"source": str(models / file), **REAL[file]})
    assert made.failed == ()


@pytest.mark.browser
def test_a_lesson_is_printed(tmp_path: Path) -> None:
    made = build(tmp_path / "site", {"source": "rr_planar"}, lessons()[:1])
    assert len(pdf_of(made.folder, lessons()[0])) > 20_000
