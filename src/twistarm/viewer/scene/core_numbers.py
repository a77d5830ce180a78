"""The numbers of an arm for the core in the page, in the order of core/wasm/module.cpp."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from typing import Any

import numpy as np

from ...arm.arm import Arm
from ...arm.engine import MOST_JOINTS
from ...arm.usual_limits import usually_limited
from ...control.servo import ServoSettings
from ...control.servo.output import REASON_OF_CAUSE
from ...control.servo.settings import servo_numbers
from ...ik.answer import STOPS
from ...ik.closed_form.methods import family_for, method_for
from ...ik.targets import FARTHEST, AnyTarget, Approach, Pose, Position
from ..messages import packed

MOST_SOLVED = 7  # Joints. A position leaves all but three of them free, and each way to hold these is tried.


@lru_cache(maxsize=2)
def core_numbers(arm: Arm) -> dict[str, Any] | None:
    """Input of the core in the page, packed float64: the `arm`, its `servo` and its `forms`.

    The servo has the usual limits. `forms` has the closed form for each kind of target that has one. `rows` names the
    rows of the servo's limits. `causes` are its reasons [name, status, words]. `reasons` are those of a solver,
    {name: words}. Both are in the core's order. None for an arm that the core does not hold.
    """
    if max(arm.coupling.A.shape) > MOST_JOINTS:
        return None
    A, limits = arm.coupling.A, arm.limits
    bounds = limits.lower, limits.upper, *arm.sampling_bounds
    motion, arrays, numbers = servo_numbers(usually_limited(arm), ServoSettings())
    motors = len(motion.names) - arm.n
    return {
        "arm": _packed(*A.shape, arm.screws, arm.home, A, *bounds, arm.reach),
        "servo": None if motors > MOST_JOINTS else _packed(*A.shape, motors, *numbers, *arrays),
        "rows": list(motion.names),
        "causes": [[reason.name, reason.status, reason.words] for reason in REASON_OF_CAUSE],
        "forms": dict(_forms(arm)),
        "reasons": {stop.name: stop.value for stop in STOPS},
    }


def _forms(arm: Arm) -> Iterator[tuple[str, str]]:
    g = arm.home
    beyond = np.abs(g[:3, 3]).max() > FARTHEST  # of targets; such an arm is in wrong units, and is shown to tell that
    if beyond or np.count_nonzero(arm.limits.lower != arm.limits.upper) > MOST_SOLVED:
        return
    p, axis = g[:3, 3], g[:3, :3] @ arm.tool_axis
    targets: tuple[AnyTarget, ...] = (Pose(g), Position(p), Approach(p, axis, arm.tool_axis))
    for target in targets:
        method = method_for(arm, target, families_alone=True)
        form = method.numbers
        if form is None:
            continue
        decides, swept = family_for(arm, target) is not None, method.sampled[0] if method.sampled else -1
        # A page holds swept joints where the arm stands: only idle ones may move for themselves.
        idle = [float(i in method.idle) for i in range(arm.n)]
        counts = len(form.axes), form.first, form.last, form.keeps, len(form.held)
        arrays = form.axes, form.kept, form.joint, form.held, form.held_axes, form.rate, form.home, idle
        yield type(target).__name__.lower(), _packed(decides, method.exact, swept, target.kind, *counts, *arrays)


def _packed(*values: Any) -> str:
    return packed(np.concatenate([np.ravel(value) for value in values]), "<f8")
