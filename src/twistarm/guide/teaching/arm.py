"""The arm of a lesson: the reader's, or a bundled one if that does not fit."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from functools import cache
from typing import Any

from ...arm.arm import Arm
from ...arm.loading.load import load_arm
from ...support.errors import InputError
from .saying import say

VARIABLE = "TWISTARM_GUIDE_ARM"
"""Environment variable with what `load_arm` takes, as JSON: {"source": "my_arm.urdf.xacro", "tip": "tool0"}."""

BUNDLED = ("rover_arm", "rover_arm_6dof", "scara", "stanford", "rr_planar", "elbow")
"""Bundled arms that may replace the reader's, in this order."""


def arm() -> Arm:
    """The arm that the lesson runs on: that of `TWISTARM_GUIDE_ARM`, else the bundled rover arm.

    Raises:
        InputError: The variable holds no JSON object with a source.
        TwistarmError: The arm cannot be loaded; the message says why.
    """
    return _loaded(os.environ.get(VARIABLE) or f'{{"source": "{BUNDLED[0]}"}}')


@cache
def bundled(name: str = BUNDLED[0]) -> Arm:
    """The rover arm that comes with twistarm (five joints), or another of the bundled arms."""
    return load_arm(name)


def arm_with(what: str, fits: Callable[[Arm], bool]) -> Arm:
    """The reader's arm if it fits, else the first fitting bundled one, with a sentence about it.

    Args:
        what: What the lesson needs, as the end of "does not have …": "three joints that turn".
        fits: Whether an arm has it.

    Returns:
        The arm.

    Raises:
        InputError: No bundled arm has it either.
    """
    own = arm()
    if fits(own):
        return own
    for name in BUNDLED:
        if fits(bundled(name)):
            say(
                f"Your arm, `{own.name}`, does not have {what}. This part of the lesson shows it on `{name}`, "
                "an arm that comes with twistarm."
            )
            return bundled(name)
    raise InputError(f"no bundled arm has {what}; the lesson can ask for {', '.join(BUNDLED)}")


@cache
def _loaded(text: str) -> Arm:
    try:
        keywords: dict[str, Any] = json.loads(text)
        source = keywords.pop("source")
    except (ValueError, AttributeError, TypeError, KeyError) as error:
        raise InputError(f'{VARIABLE} takes JSON like {{"source": "my_arm.urdf"}}; got {text!r}') from error
    return load_arm(source, **keywords)
