"""Arms as sealed files of numbers, read without Pinocchio or the description: baked arms and golden files."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..description.document import read_text
from ..limits.actuators import Actuators
from ..limits.joint_limits import FIELDS, JointLimits, unit_of
from ..support.checks import Array
from ..support.errors import DescriptionError, InputError
from ..support.files import writable, write_whole
from ..support.strict_json import parsed
from .arm import Arm, require_arm

SUFFIX = ".json"

VERSION = 1

MAX_BYTES = 10_000_000  # Six joints have some 5 kB; 250 joints and a coupling between all of them 2 MB.


class Kind(NamedTuple):
    """A kind of sealed file: the format that it says, its name, and the command that writes one."""

    format: str
    name: str
    command: str


BAKED = Kind("twistarm arm", "baked arm", "twistarm bake ARM -o FILE")

_PROOF = ("pose_error", "jacobian_error", "samples")

# -- writing -----------------------------------------------------------------------------------------------------


def bake(arm: Arm, path: str | os.PathLike[str]) -> Path:
    """Write the arm as numbers to an arm.json, which `load_arm` reads without Pinocchio and the description.

    The file holds everything except `description` and `findings`. The same arm gives the same bytes. An error leaves no
    partial file.

    Args:
        arm: The arm.
        path: The file, with the ending .json.

    Returns:
        The path.

    Raises:
        InputError: The name lacks the ending .json, or the file cannot be written.
    """
    require_arm(arm)
    target = writable(path)
    if target.suffix != SUFFIX:
        raise InputError(f"a baked arm is named *{SUFFIX}; got {os.fspath(path)}")
    return write_whole(target, text_of(arm))


def text_of(arm: Arm) -> str:
    """The text of an arm.json."""
    return sealed(BAKED, content_of(arm))


def digest_of(arm: Arm) -> str:
    """`sha256:…` of the contents. Two arms with the same digest are equal to the last bit."""
    return _digest_of(content_of(arm))


def content_of(arm: Arm) -> dict[str, Any]:
    """An arm without its description and findings, for JSON; SI, as in `Arm`. `source` without its folder."""
    bounds, motors = _bounds(arm.limits), arm.actuators
    return {
        "name": arm.name,
        "source": Path(arm.source).name,
        "base": arm.base,
        "tip": arm.tip,
        "tip_link": arm.tip_link,
        "joints": [
            {"name": name, "type": kind, "unit": unit_of(kind)} | {field: bounds[field][i] for field in FIELDS}
            for i, (name, kind) in enumerate(zip(arm.joint_names, arm.joint_types, strict=True))
        ],
        "moving": list(arm.moving_names),
        "screws": arm.screws.tolist(),
        "home": arm.home.tolist(),
        "tool": arm.tool.tolist(),
        "coupling": {"A": arm.coupling.A.tolist(), "b": arm.coupling.b.tolist()},
        "reach": float(arm.reach),
        "ready": arm.ready.tolist(),
        "named_states": {name: theta.tolist() for name, theta in arm.named_states.items()},
        "actuators": motors
        and {
            "names": list(motors.names),
            "G": motors.G.tolist(),
            "offset": motors.offset.tolist(),
            "units": list(motors.units),
            "ticks_per_turn": _or_null(motors.ticks_per_turn),
            "limits": _bounds(motors.limits),
        },
        "disabled_collisions": [list(pair) for pair in sorted(arm.disabled_collisions)],
        "proof": None if arm.proof is None else dict(zip(_PROOF, arm.proof, strict=True)),
    }


def sealed(kind: Kind, content: Mapping[str, Any]) -> str:
    """The file's text: JSON with a digest of the rest. Every number reads back as the same bits."""
    entries = {"format": kind.format, "version": VERSION, "digest": _digest_of(content), **content}
    return "{\n" + ",\n".join(f"  {json.dumps(key)}: {_laid_out(value)}" for key, value in entries.items()) + "\n}\n"


def _bounds(limits: JointLimits) -> dict[str, list[float | None]]:
    return {field: _or_null(getattr(limits, field)) for field in FIELDS}


def _or_null(values: Array) -> list[float | None]:
    """Numbers for JSON, with null for infinity and NaN."""
    return [float(value) if np.isfinite(value) else None for value in values]


def _digest_of(content: Mapping[str, Any]) -> str:
    """A digest independent of the file's layout and order. ValueError for a number that JSON lacks."""
    canonical = json.dumps(content, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return f"sha256:{hashlib.sha256(canonical.encode('ascii')).hexdigest()}"


def _laid_out(value: Any) -> str:
    """One line, or one for each row of a matrix and for each joint."""
    if isinstance(value, list) and any(isinstance(item, (list, dict)) for item in value):
        return "[\n    " + ",\n    ".join(map(json.dumps, value)) + "\n  ]"
    return json.dumps(value)


# -- reading -----------------------------------------------------------------------------------------------------


def unsealed(path: Path, *kinds: Kind) -> dict[str, Any]:
    """The content of a sealed file of one of these kinds, after a check of format, version and digest.

    Raises DescriptionError for any other file, and for one that was changed. The digest fits only what `sealed` wrote,
    so the numbers need no check.
    """
    first = kinds[0]
    try:
        content = parsed(read_text(path, MAX_BYTES))
        format_name = content.get("format") if isinstance(content, dict) else None
        kind = next((known for known in kinds if known.format == format_name), None)
        if kind is None:
            raise ValueError(f"it does not say 'format': {first.format!r}")
        _, version, digest = (content.pop(key, None) for key in ("format", "version", "digest"))
        whole = digest == _digest_of(content)
    except (ValueError, RecursionError) as error:
        raise DescriptionError(f"{path}: not a {first.name}: {error}; {first.command} writes one") from error
    again = f"write it again from the description: {kind.command} --force"
    if version != VERSION:
        update = f"it is of version {str(version)[:20]}, and this twistarm reads version {VERSION}"
        raise DescriptionError(f"{path}: {update}; {again}")
    if not whole:
        raise DescriptionError(f"{path}: edited or damaged since it was written (its digest does not fit); {again}")
    return dict(content)


def fields_of(content: Mapping[str, Any]) -> dict[str, Any]:
    """The fields of an `Arm` from its content; `coupling` and `proof` as tuples."""
    joints, motors, proof = content["joints"], content["actuators"], content["proof"]
    names = tuple(joint["name"] for joint in joints)
    if motors is not None:
        motors = Actuators(
            names=tuple(motors["names"]),
            joint_names=names,
            G=np.array(motors["G"]),
            offset=np.array(motors["offset"]),
            units=tuple(motors["units"]),
            ticks_per_turn=_given(motors["ticks_per_turn"], np.nan),
            limits=_limits(motors["limits"]),
        )
    return {
        **{key: content[key] for key in ("name", "source", "base", "tip", "tip_link", "reach")},
        "joint_names": names,
        "joint_types": tuple(joint["type"] for joint in joints),
        "moving_names": tuple(content["moving"]),
        **{key: np.array(content[key]) for key in ("screws", "home", "tool")},
        "coupling": (np.array(content["coupling"]["A"]), np.array(content["coupling"]["b"])),
        "limits": _limits({field: [joint[field] for joint in joints] for field in FIELDS}),
        "known_ready": np.array(content["ready"]),
        "named_states": {name: np.array(theta) for name, theta in content["named_states"].items()},
        "actuators": motors,
        "disabled_collisions": frozenset(map(tuple, content["disabled_collisions"])),
        "proof": None if proof is None else tuple(proof[key] for key in _PROOF),
    }


def _limits(content: Mapping[str, list[float | None]]) -> JointLimits:
    """Limits by field. Null means not given."""
    return JointLimits(**{field: _given(content[field], -np.inf if field == "lower" else np.inf) for field in FIELDS})


def _given(values: list[float | None], absent: float) -> Array:
    """Numbers, `absent` for null."""
    return np.array([absent if value is None else value for value in values], dtype=np.float64)
