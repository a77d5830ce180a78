"""An arm as a function of MATLAB and Octave: screws, forward kinematics, Jacobians, test vectors."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from ..arm.arm import Arm
from ..arm.baking import digest_of
from ..support.checks import Array
from ..support.code_text import filled
from ..support.errors import InputError, printable

TEMPLATE = Path(__file__).with_name("templates") / "arm.m.in"

SUFFIX = ".m"

LONGEST = 63  # Most characters of a name in MATLAB.

KEYWORDS = """
    break case catch classdef continue do else elseif end enumeration events for function global if methods otherwise
    parfor persistent properties return spmd switch try unwind_protect unwind_protect_cleanup until while
"""
"""Keywords of MATLAB and Octave."""

# Configurations with which the file tests itself: the ready configuration, and random ones inside the limits.
VECTORS = 5
TOLERANCE = 1e-9  # Tolerance of the test [m, and none]. Rounding is far smaller, a wrong sign far larger.


def matlab_text(arm: Arm, file: str | None = None) -> str:
    """The text of a file with this name, by default the arm's. MATLAB calls a function by its file name.

    The test vectors are Pinocchio's where the arm has a description. InputError for a name that no function can have.
    """
    name = _function_name(arm.name) if file is None else Path(file).stem
    if name != (better := _function_name(name)):
        raise InputError(
            f"MATLAB calls a function by its file's name, of letters, digits and _: {name!r} is none; "
            f"call the file {better}{SUFFIX}"
        )
    theta = np.vstack([arm.ready, arm.random_theta(0, VECTORS - 1)])  # seeded: the same arm gives the same file
    by_pinocchio = arm.description is not None
    own = arm.fk(theta), arm.spatial_jacobian(theta), arm.body_jacobian(theta)
    g, spatial, body = arm.by_pinocchio(theta) if by_pinocchio else own
    return filled(
        TEMPLATE,
        name=name,
        title=name.upper(),
        arm=printable(arm.name),
        base=printable(arm.base),
        tip=printable(arm.tip),
        order=", ".join(f"{printable(joint)} [{unit}]" for joint, unit in zip(arm.joint_names, arm.units, strict=True)),
        digest=digest_of(arm),
        name_text=_text(arm.name),
        joint_names=_texts(arm.joint_names),
        units=_texts(arm.units),
        screws=_matrix(arm.screws),
        home=_matrix(arm.home),
        coupling=_matrix(arm.coupling.A),
        limits="\n".join(
            f"arm.{field} = {_matrix(getattr(arm.limits, field)[None])};"
            for field in ("lower", "upper", "velocity", "acceleration", "effort")
        ),
        ready=_matrix(arm.ready[None]),
        judge="Pinocchio" if by_pinocchio else "twistarm",
        tolerance=repr(TOLERANCE * max(1.0, arm.reach)),
        theta=_matrix(theta),
        g=_matrix(np.hstack(list(g))),
        spatial=_matrix(np.hstack(list(spatial))),
        body=_matrix(np.hstack(list(body))),
    )


def _function_name(name: str) -> str:
    """The name itself if MATLAB and Octave allow it for a function, or one near it."""
    identifier = re.sub(r"[^A-Za-z0-9_]+", "_", name).lstrip("_")[:LONGEST] or "arm"
    return f"arm_{identifier}"[:LONGEST] if identifier[0].isdigit() or identifier in KEYWORDS.split() else identifier


def _matrix(rows: Array) -> str:
    """A matrix, a line for each of several rows."""
    lines = [", ".join(map(repr, row)) for row in np.asarray(rows, np.float64).tolist()]  # inf too
    return f"[{lines[0]}]" if len(lines) == 1 else "[\n    " + "\n    ".join(lines) + "]"


def _texts(texts: Iterable[str]) -> str:
    return "{" + ", ".join(map(_text, texts)) + "}"


def _text(text: str) -> str:
    """A text between single quotes, which only a quote can end."""
    return "'" + printable(text).replace("'", "''") + "'"
