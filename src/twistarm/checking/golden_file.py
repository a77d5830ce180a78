"""Golden files: an arm frozen as numbers, written and read."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import numpy as np

from ..arm.arm import Arm, require_arm
from ..arm.baking import FORMAT as BAKED
from ..arm.baking import actuators_entry, joints_entry, read_actuators, read_limits, reason
from ..description.document import read_text
from ..description.inertial import Body, bodies
from ..limits.joint_limits import FIELDS
from ..support.checks import as_floats, as_pose
from ..support.errors import DescriptionError
from ..support.files import write_whole
from ..support.strict_json import parsed
from .crosscheck import by_exponentials

FORMAT = "twistarm golden 1"

MAX_BYTES = 10_000_000
"""Six joints have some 200 kB; 250 joints 7 MB."""

SAMPLES = 100

NOT_COVERED = (
    "shapes and meshes",
    "named poses and the SRDF",
    "limits of joints beside the chain",
    "damping and friction",
)
"""What a golden file says nothing of."""

_FREEZE = "twistarm freeze writes one"


def freeze(arm: Arm, path: str | os.PathLike[str]) -> None:
    """Write the arm as numbers (JSON, SI).

    The file holds names, screws, home, limits, motors and each link's mass, centre and inertia. It also holds FK and
    Jacobians at 100 seeded postures. They come from the product of exponentials, so the file depends on no engine.

    Shapes and meshes, named poses, the SRDF, limits of joints beside the chain, damping and friction are not covered.
    The file lists them. It is written whole or not at all.

    Args:
        arm: The arm.
        path: The file to write; an existing golden file is replaced.

    Raises:
        InputError: The file cannot be written.
    """
    write_whole(path, golden_text(arm))


def golden_text(arm: Arm) -> str:
    """What `freeze` writes."""
    theta = require_arm(arm).random_theta(0, SAMPLES)
    g, spatial, body = by_exponentials(arm, theta)
    content = {
        "format": FORMAT,
        "name": arm.name,
        "base": arm.base,
        "tip": arm.tip,
        "joints": joints_entry(arm.joint_names, arm.joint_types, arm.limits),
        "screws": arm.screws.tolist(),
        "home": arm.home.tolist(),
        "coupling": {"A": arm.coupling.A.tolist(), "b": arm.coupling.b.tolist()},
        "bodies": None
        if arm.description is None
        else {
            link: {"mass": body.mass, "centre": body.centre.tolist(), "inertia": body.inertia.tolist()}
            for link, body in bodies(arm.description).items()
        },
        "not_covered": NOT_COVERED,
        "actuators": None if arm.actuators is None else actuators_entry(arm.actuators),
        "theta": theta.tolist(),
        "fk": g.tolist(),
        "spatial_jacobian": spatial.tolist(),
        "body_jacobian": body.tolist(),
    }
    return json.dumps(content, allow_nan=False) + "\n"


def golden_content(arm: Arm) -> dict[str, Any]:
    """What `read_golden` would return of a file that the arm was frozen in just now."""
    content: dict[str, Any] = json.loads(golden_text(arm))
    return {**content, **_checked(content)}


def read_golden(path: Path) -> dict[str, Any] | None:
    """A golden file's checked content; None for a baked arm.

    Raises DescriptionError for other or damaged files.
    """
    try:
        content = parsed(read_text(path, MAX_BYTES))
    except ValueError as error:
        raise DescriptionError(f"{path}: not a golden file: {error}; {_FREEZE}") from error
    kind = content.get("format") if isinstance(content, dict) else None
    if kind == BAKED:
        return None
    if kind != FORMAT:
        raise DescriptionError(f"{path}: not a golden file of this version ({FORMAT!r}); {_FREEZE}")
    try:
        return {**content, **_checked(content)}
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise DescriptionError(
            f"{path}: a damaged golden file ({reason(error)}); write it anew with twistarm freeze"
        ) from error


def _checked(content: dict[str, Any]) -> dict[str, Any]:
    """The arrays, limits and motors of a golden file, checked against its joints. Raises ValueError otherwise."""
    n, m = len(content["joints"]), len(content["coupling"]["b"])
    N = len(content["theta"])
    shapes = {
        "screws": (6, m), "home": (4, 4), "theta": (N, n), "fk": (N, 4, 4),
        "spatial_jacobian": (N, 6, n), "body_jacobian": (N, 6, n),
    }  # fmt: skip
    arrays = {name: as_floats(content[name], name) for name in shapes}
    arrays |= {"A": as_floats(content["coupling"]["A"], "A"), "b": as_floats(content["coupling"]["b"], "b")}
    for name, shape in {**shapes, "A": (m, n), "b": (m,)}.items():
        if arrays[name].shape != shape:
            raise ValueError(f"{name} has shape {arrays[name].shape} instead of {shape}")
    if not np.abs(arrays["screws"]).max(axis=0).all():
        raise ValueError("a joint with a zero screw")
    as_pose(arrays["home"], "home")
    joints = content["joints"]
    for joint in joints:
        if not all(isinstance(joint[key], str) for key in ("name", "type")):
            raise ValueError("a joint without name or type")
    if not all(isinstance(content[key], str) for key in ("base", "tip")):
        raise ValueError("no base or no tip")
    read: dict[str, Any] = {"limits": read_limits({field: [joint[field] for joint in joints] for field in FIELDS})}
    written = content["bodies"]
    read["bodies"] = None if written is None else {link: _body(body, link) for link, body in written.items()}
    read["actuators"] = read_actuators(content["actuators"], tuple(joint["name"] for joint in joints))
    return arrays | read


def _body(written: dict[str, Any], link: str) -> Body:
    centre, inertia = (as_floats(written[name], name) for name in ("centre", "inertia"))
    if centre.shape != (3,) or inertia.shape != (3, 3):
        raise ValueError(f"the body of {link} has no centre (3,) or no inertia (3, 3)")
    return Body(float(as_floats(written["mass"], "mass")), centre, inertia)
