"""The course of one lesson that tests read, and the real arms that every lesson runs on."""

from typing import Any

from test_loading import REAL

LESSON = "3_1_forward_kinematics"

ROVER: dict[str, Any] = {"source": "rover_arm"}

REAL_ARMS = [(file, {"tip": tip, "xacro_args": arguments}) for file, arguments, tip, _ in REAL.values()]
