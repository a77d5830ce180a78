"""The real arms that must load, with what `load_arm` needs for each."""

from __future__ import annotations

from typing import Any

REAL_ARMS: list[tuple[str, dict[str, Any]]] = [
    ("robojackets_slider_arm/cartesian_controller_simulation/urdf/arm_gazebo.urdf.xacro", {"tip": "tool0"}),
    ("robojackets_walliiarmv3/urc_gazebo/urdf/WalliiArmV3.urdf", {"tip": "claw"}),
    ("robojackets_walli_v2_block/urdf/walli_arm_v2_block/robot.urdf", {"tip": "ee"}),
    ("ur_description/urdf/ur.urdf.xacro", {"tip": "tool0", "xacro_args": {"name": "ur", "ur_type": "ur5e"}}),
    ("so101/so101_new_calib.urdf", {"tip": "gripper_frame_link"}),
    ("annin_ar4_description/urdf/ar.urdf.xacro", {"tip": "ee_link", "xacro_args": {"ar_model": "mk3"}}),
    ("kortex_description/robots/gen3.xacro", {"tip": "tool_frame", "xacro_args": {"dof": 7}}),
    ("kortex_description/robots/gen3_lite.urdf", {"tip": "tool_frame"}),
]
