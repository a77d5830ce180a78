"""The course of one lesson that tests read."""

from __future__ import annotations

from typing import Any

LESSON = "3_1_forward_kinematics"

ROVER: dict[str, Any] = {"source": "rover_arm"}
