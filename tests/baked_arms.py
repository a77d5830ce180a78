"""An arm that has everything a baked arm may have, and what makes two arms the same."""

from __future__ import annotations

import hashlib
import json
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from twistarm import Arm, load_arm
from twistarm import bake as write_baked
from twistarm.limits.joint_limits import FIELDS
from urdf_text import joint, robot, write

TOL = 1e-12

EVERYTHING = """
source = "arm.urdf"
name = "everything"

[tool]
name = "gripper"
xyz = [0.0, 0.01, 0.12]
rpy = [0.0, 0.1, 0.0]

[poses]
ready = { a = 0.1, c = -0.2 }
home = { a = 0.0, c = 0.0 }

[actuators.left]
ratio = { a = 9.0, c = 3.0 }
offset = 0.25
unit = "tick"
ticks_per_turn = 4096

[actuators.right]
ratio = { a = -9.0, c = 3.0 }
limits = { lower = -40.0, velocity = 0.1, acceleration = 3.5, effort = 2.0 }
"""

SRDF = """<robot name="tiny"><disable_collisions link1="upper" link2="base_link" reason="Adjacent"/></robot>"""


@pytest.fixture
def everything(tmp_path: Path) -> Arm:
    """A follower, a locked offset, a tool, poses, motors, an SRDF."""
    links = ("base_link", "upper", "fore", "tool0")
    follows = '<axis xyz="0 1 0"/><mimic joint="a" multiplier="-0.5" offset="0.3"/>'
    parts = [
        joint("a", "base_link", "upper", xyz="0.1 0 0.3", rpy="0.2 0 0"),
        joint("b", "upper", "fore", inside=follows, xyz="0.4 0 0"),
        joint("c", "fore", "tool0", kind="continuous", inside='<axis xyz="1 0 0"/>', xyz="0.3 0 0"),
    ]
    write(tmp_path, robot(*parts, links=links))
    write(tmp_path, SRDF, "tiny.srdf")
    return load_arm(write(tmp_path, EVERYTHING, "arm.toml"))


def bake(arm: Arm, folder: Path) -> Path:
    return write_baked(arm, folder / "baked.json")


def assert_same(baked: Arm, arm: Arm) -> None:
    """Everything about the chain, bit for bit where it is data."""
    left_out = {"source", "findings", "description", "couplings", "known_ready"}
    for name in {field.name for field in fields(Arm)} - left_out:
        one, other = getattr(baked, name), getattr(arm, name)
        if name == "limits":
            assert all(np.array_equal(getattr(one, field), getattr(other, field)) for field in FIELDS)
        elif name == "coupling":
            assert all(np.array_equal(a, b) for a, b in zip(one, other, strict=True))
        elif name == "named_states":
            assert list(one) == list(other)
            assert all(np.array_equal(one[key], other[key]) for key in other)
        elif name == "actuators":
            assert (one is None) == (other is None)
            if one is not None:
                assert all(np.array_equal(getattr(one, key), getattr(other, key))
                           for key in ("names", "joint_names", "G", "offset", "units"))  # fmt: skip
                assert np.array_equal(one.ticks_per_turn, other.ticks_per_turn, equal_nan=True)
                assert all(np.array_equal(getattr(one.limits, f), getattr(other.limits, f)) for f in FIELDS)
        else:
            assert np.array_equal(one, other), name
    assert np.array_equal(baked.ready, arm.ready)
    assert np.array_equal(baked.usual_half, arm.usual_half)
    assert baked.units == arm.units
    assert baked.frame_names == (arm.base, arm.tip)


def sealed(content: dict[str, Any]) -> str:
    """A file with a digest that fits, worked out as the format says: SHA-256 of the rest, sorted, without spaces."""
    rest = {key: value for key, value in content.items() if key not in ("format", "version", "digest")}
    digest = hashlib.sha256(json.dumps(rest, sort_keys=True, separators=(",", ":")).encode()).hexdigest()
    return json.dumps({**content, "digest": f"sha256:{digest}"})
