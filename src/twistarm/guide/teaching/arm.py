"""The arm of a lesson: the reader's own, or a bundled one."""

from __future__ import annotations

import json
import os

from ...loading.load import load_arm
from ...model.arm import Arm

VARIABLE = "TWISTARM_GUIDE_ARM"
"""Environment variable with what `load_arm` takes, as JSON: {"source": "my_arm.urdf.xacro", "tip": "tool0"}."""


def arm() -> Arm:
    """The arm that the lesson runs on: that of `TWISTARM_GUIDE_ARM`, else the bundled rover arm."""
    return load_arm(**json.loads(os.environ.get(VARIABLE) or '{"source": "rover_arm"}'))
