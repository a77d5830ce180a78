"""Baked arms: a chain as one file of numbers (arm.json), read without Pinocchio or the description."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..description.document import read_text
from ..limits.actuators import Actuators
from ..limits.joint_limits import FIELDS, JointLimits
from ..limits.joint_units import unit_of
from ..support.checks import Array, as_floats, as_number, as_pose, as_positive
from ..support.errors import DescriptionError, InputError
from ..support.files import writable, write_whole
from ..support.strict_json import parsed, text

SUFFIX = ".json"
FORMAT, VERSION = "twistarm arm", 1

MAX_BYTES = 10_000_000
"""Six joints have some 5 kB; 250 joints and a coupling between all of them 2 MB."""

LARGEST, LEAST = 1e12, 1e-9
"""The largest number of a chain, and the least reach [m] or screw. Beyond these, products overflow."""

FARTHEST = 1e6
"""The largest joint value [rad, m]. A larger angle has too few digits left for an answer."""

JOINT_TYPES = ("revolute", "continuous", "prismatic", "helical")

_BAKE = "twistarm bake ARM -o FILE writes one"
_AGAIN = "bake it again from the description: twistarm bake ARM -o FILE --force"


class Baked(NamedTuple):
    """The contents of the file: an arm without its description and findings. SI, as in `Arm`.

    `source` is the name of the description's file, without its folder.
    """

    name: str
    source: str
    base: str
    tip: str
    tip_link: str
    joint_names: tuple[str, ...]
    joint_types: tuple[str, ...]
    moving_names: tuple[str, ...]
    screws: Array
    home: Array
    tool: Array
    coupling: tuple[Array, Array]
    limits: JointLimits
    reach: float
    ready: Array
    named_states: Mapping[str, Array]
    actuators: Actuators | None
    disabled_collisions: frozenset[tuple[str, str]]
    proof: tuple[float, float, int] | None


# -- writing -----------------------------------------------------------------------------------------------------


def write_baked(baked: Baked, path: str | os.PathLike[str]) -> Path:
    """Write an arm.json and return its path. An error leaves no partial file. The same arm gives the same bytes.

    Raises InputError for a name without the ending .json, and for the reasons of `write_whole`.
    """
    target = writable(path)
    if target.suffix != SUFFIX:
        raise InputError(f"a baked arm is named *{SUFFIX}; got {os.fspath(path)}")
    return write_whole(target, text_of(baked))


def text_of(baked: Baked) -> str:
    """The file's text: JSON with a digest of the rest. Every number reads back as the same bits."""
    content = _content(baked)
    entries = {"format": FORMAT, "version": VERSION, "digest": _digest_of(content), **content}
    return "{\n" + ",\n".join(f"  {json.dumps(key)}: {_laid_out(value)}" for key, value in entries.items()) + "\n}\n"


def digest_of(baked: Baked) -> str:
    """`sha256:…` of the contents. Two arms with the same digest are equal to the last bit."""
    return _digest_of(_content(baked))


def _content(baked: Baked) -> dict[str, Any]:
    A, b = baked.coupling
    proof = None if baked.proof is None else dict(zip(_PROOF, baked.proof, strict=True))
    return {
        "name": baked.name,
        "source": Path(baked.source).name,
        "base": baked.base,
        "tip": baked.tip,
        "tip_link": baked.tip_link,
        "joints": joints_entry(baked.joint_names, baked.joint_types, baked.limits),
        "moving": list(baked.moving_names),
        "screws": baked.screws.tolist(),
        "home": baked.home.tolist(),
        "tool": baked.tool.tolist(),
        "coupling": {"A": A.tolist(), "b": b.tolist()},
        "reach": float(baked.reach),
        "ready": baked.ready.tolist(),
        "named_states": {name: theta.tolist() for name, theta in baked.named_states.items()},
        "actuators": None if baked.actuators is None else actuators_entry(baked.actuators),
        "disabled_collisions": [list(pair) for pair in sorted(baked.disabled_collisions)],
        "proof": proof,
    }


_PROOF = ("pose_error", "jacobian_error", "samples")


def joints_entry(names: Sequence[str], types: Sequence[str], limits: JointLimits) -> list[dict[str, Any]]:
    """The joints as written to an arm.json and a golden file."""
    bounds = _bounds(limits)
    return [
        {"name": name, "type": kind, "unit": unit_of(kind)} | {field: bounds[field][i] for field in FIELDS}
        for i, (name, kind) in enumerate(zip(names, types, strict=True))
    ]


def actuators_entry(motors: Actuators) -> dict[str, Any]:
    """The motors as written to an arm.json and a golden file."""
    return {
        "names": list(motors.names),
        "G": motors.G.tolist(),
        "offset": motors.offset.tolist(),
        "units": list(motors.units),
        "ticks_per_turn": _or_null(motors.ticks_per_turn),
        "limits": _bounds(motors.limits),
    }


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


def read_baked(path: Path) -> Baked:
    """Read and check an arm.json. DescriptionError for any other file, and for one that was changed."""
    content = _content_of(path)
    try:
        return _checked(content)
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise DescriptionError(f"{path}: an unusable baked arm ({reason(error)}); {_AGAIN}") from error


def _content_of(path: Path) -> dict[str, Any]:
    """The file's content, after a check of format, version and digest."""
    try:
        content = parsed(read_text(path, MAX_BYTES))
        if not isinstance(content, dict) or content.get("format") != FORMAT:
            raise ValueError(f"it does not say 'format': {FORMAT!r}")
        version = content.get("version")
        if version != VERSION:
            update = f"it is of version {str(version)[:20]}, and this twistarm reads version {VERSION}"
            raise DescriptionError(f"{path}: {update}; {_AGAIN}")
        kept = {key: value for key, value in content.items() if key not in ("format", "version", "digest")}
        whole = content.get("digest") == _digest_of(kept)
    except (ValueError, RecursionError) as error:
        raise DescriptionError(f"{path}: not a baked arm: {error}; {_BAKE}") from error
    if not whole:
        raise DescriptionError(f"{path}: edited or damaged since it was baked (its digest does not fit); {_AGAIN}")
    return kept


def reason(error: Exception) -> str:
    """The words for an error in a file of numbers."""
    return f"{error} is missing" if isinstance(error, KeyError) else str(error)


def _checked(content: dict[str, Any]) -> Baked:
    """Check names, shapes, units and numbers. Raise KeyError, TypeError or ValueError."""
    joints = content["joints"]
    names = _names([joint["name"] for joint in joints], "joints")
    moving = _names(content["moving"], "moving")
    n, m = len(names), len(moving)
    screws = _array(content["screws"], "screws", (6, m))
    if not (np.abs(screws).max(axis=0) >= LEAST).all():
        raise ValueError("a joint with a zero screw")
    limits = read_limits({field: [joint[field] for joint in joints] for field in FIELDS})
    for name, lower, upper in zip(names, limits.lower, limits.upper, strict=True):
        if lower > FARTHEST or upper < -FARTHEST:
            raise ValueError(f"{name} would be confined to {lower:g} to {upper:g}, beyond {FARTHEST:g} rad or m")
    ready = _array(content["ready"], "ready", (n,), FARTHEST)
    if not limits.contains(ready):
        raise ValueError("ready lies outside the limits")
    coupling = content["coupling"]
    return Baked(
        **{key: text(content[key], key) for key in ("name", "source", "base", "tip", "tip_link")},
        joint_names=names,
        joint_types=tuple(_type(joint) for joint in joints),
        moving_names=moving,
        screws=screws,
        home=_pose(content["home"], "home"),
        tool=_pose(content["tool"], "tool"),
        coupling=(_array(coupling["A"], "A", (m, n)), _array(coupling["b"], "b", (m,))),
        limits=limits,
        reach=_reach(content["reach"]),
        ready=ready,
        named_states={name: _array(x, f"pose {name}", (n,), FARTHEST) for name, x in content["named_states"].items()},
        actuators=read_actuators(content["actuators"], names),
        disabled_collisions=frozenset(_pair(pair) for pair in content["disabled_collisions"]),
        proof=_read_proof(content["proof"]),
    )


def _names(values: list[Any], what: str) -> tuple[str, ...]:
    names = tuple(text(value, what) for value in values)
    if not names or len(set(names)) != len(names):
        raise ValueError(f"{what} must be different names, at least one")
    return names


def _type(joint: Mapping[str, Any]) -> str:
    kind, unit = joint["type"], joint["unit"]
    if kind not in JOINT_TYPES or unit != unit_of(kind):
        raise ValueError(f"a joint is {', '.join(JOINT_TYPES)}, in rad or m; got {kind!r} in {unit!r}")
    return str(kind)


def _array(value: ArrayLike, name: str, shape: tuple[int, ...], most: float = LARGEST) -> Array:
    array = as_floats(value, name)
    if array.shape != shape:
        raise ValueError(f"{name} must have shape {shape}; got {array.shape}")
    if np.abs(array).max(initial=0.0) > most:
        raise ValueError(f"{name} holds {np.abs(array).max():g}, beyond {most:g}")
    return array


def _reach(value: ArrayLike) -> float:
    reach = as_positive(value, "reach")
    if not LEAST <= reach <= LARGEST:
        raise ValueError(f"reach must be from {LEAST:g} to {LARGEST:g} m; got {reach:g}")
    return reach


def _pose(value: ArrayLike, name: str) -> Array:
    """The pose as written. It is not cleaned, so the arm baked again gives the same file."""
    g = _array(value, name, (4, 4))
    as_pose(g, name)
    return g


def _given(values: list[float | None], name: str, absent: float) -> Array:
    """Finite numbers, `absent` for null."""
    finite = as_floats([0.0 if value is None else value for value in values], name)
    return np.where([value is None for value in values], absent, finite)


def read_actuators(content: Mapping[str, Any] | None, joint_names: tuple[str, ...]) -> Actuators | None:
    """The motors of an entry. Raise KeyError, TypeError or ValueError for a wrong entry."""
    if content is None:
        return None
    return Actuators(
        names=_names(content["names"], "actuators"),
        joint_names=joint_names,
        G=as_floats(content["G"], "G"),
        offset=as_floats(content["offset"], "offset"),
        units=tuple(content["units"]),
        ticks_per_turn=_given(content["ticks_per_turn"], "ticks_per_turn", np.nan),
        limits=read_limits(content["limits"]),
    )


def read_limits(content: Mapping[str, Any]) -> JointLimits:
    """Limits by field; null means not given."""
    absent = {field: -np.inf if field == "lower" else np.inf for field in FIELDS}
    return JointLimits(**{field: _given(content[field], field, absent[field]) for field in FIELDS})


def _pair(value: Any) -> tuple[str, str]:
    first, second = (text(link, "disabled_collisions") for link in value)
    return first, second


def _read_proof(content: Mapping[str, Any] | None) -> tuple[float, float, int] | None:
    if content is None:
        return None
    pose_error, jacobian_error, samples = (as_number(content[key], key) for key in _PROOF)
    return pose_error, jacobian_error, int(samples)
