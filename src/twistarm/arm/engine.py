"""The compiled core: `twistarm._core` where it was built, and the reason where it was not."""

from __future__ import annotations

import importlib
import logging
from functools import cache
from types import ModuleType
from typing import TYPE_CHECKING, Any

from ..support.checks import Array
from ..support.errors import TwistarmError

if TYPE_CHECKING:
    from .._core import Chain as Chain
    from .._core import Servo as Servo

INTERFACE = 16
"""Of the compiled core that this Python speaks to; one more whenever the meaning of a call changes."""

MOST_JOINTS = 32
"""Moving joints, or coordinates, that a chain of the core holds."""

_PACKAGE = __package__.partition(".")[0]
_LOG = logging.getLogger(_PACKAGE)

_AGAIN = "pip install --force-reinstall --no-deps --no-cache-dir twistarm (or . in a checkout)"


def core() -> ModuleType | None:
    """The compiled core (its names are in _core.pyi), or None; `why_not` then says why."""
    return _found()[0]


def why_not() -> str:
    """Why there is no compiled core and the remedy, in one line; empty with a core."""
    return _found()[1]


def need(what: str) -> ModuleType:
    """The compiled core. Raises TwistarmError with the remedy if `what` cannot have it."""
    module = core()
    if module is None:
        raise TwistarmError(f"{what} needs the compiled core: {why_not()}")
    return module


def asked(name: str, *given: object) -> Any:
    """The answer of a core function; None without a core, or if Python must check the arguments."""
    module = core()
    return None if module is None else getattr(module, name)(*given)


def instruction_set() -> str:
    """The instruction set of the core's kernels (avx512, avx2, baseline); empty without a core."""
    module = core()
    return "" if module is None else str(module.instruction_sets()[0])


def chain_of(
    screws: Array,
    home: Array,
    A: Array,
    limits: tuple[Array, Array],
    starts: tuple[Array, Array],
    reach: float,
    rounding: tuple[float, float],
) -> Chain | None:
    """The chain of screws (6, m), home and A (m, n) in the core; None without a core or beyond its size.

    `limits` are the lower and upper bounds (n,), `starts` the finite bounds of random starts. `reach` [m] compares
    metres with radians in a rank. `rounding` [m], [rad] is the allowed miss due to rounded axes.
    """
    module = core()
    if module is None:
        _say_once()
        return None
    if max(A.shape) > MOST_JOINTS:
        _LOG.warning("%d joints are more than the compiled core holds (%d)", max(A.shape), MOST_JOINTS)
        return None
    chain: Chain = module.Chain(screws, home, A, *limits, *starts, reach, *rounding)
    return chain


def servo_of(arrays: tuple[Array, ...], length: float, below: float, damping: float, stops: bool) -> Servo:
    """The servo of an arm in the core, from what `_core.Servo` takes. TwistarmError as for `need`, or for its size."""
    module, most = need("the servo"), max(max(array.shape) for array in arrays[2:5])
    if most > MOST_JOINTS:
        raise TwistarmError(f"the servo drives at most {MOST_JOINTS} joints or motors; this arm has {most}")
    servo: Servo = module.Servo(*arrays, length, below, damping, stops)
    return servo


@cache
def _say_once() -> None:
    """Log once that everything is slower without the core; the default log is stderr."""
    lost = "takes milliseconds instead of microseconds and gives neither the nearest configuration nor the reason"
    _LOG.warning("no compiled core, so inverse kinematics %s: %s", lost, why_not())


@cache
def _found() -> tuple[ModuleType | None, str]:
    name = f"{_PACKAGE}._core"
    try:
        module = importlib.import_module(name)
    except ModuleNotFoundError as error:
        if error.name != name:
            return None, f"{name} cannot be imported ({error}); {_AGAIN}"
        return None, (
            "twistarm was installed where it could not be compiled; get a C++17 compiler "
            f"(apt install g++, xcode-select --install), then {_AGAIN}"
        )
    except ImportError as error:
        return None, f"{name} cannot be loaded ({error}); {_AGAIN}"
    found = getattr(module, "INTERFACE", None)
    if found != INTERFACE:
        return None, f"{name} was built from other sources (interface {found}, needed {INTERFACE}); {_AGAIN}"
    return module, ""
