"""The compiled core `twistarm._core`, or the reason why it is missing."""

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

INTERFACE = 19
"""Version of the compiled core that this Python needs. It rises with each change of a call."""

MOST_JOINTS = 32
"""The most moving joints or coordinates of a chain in the core."""

_PACKAGE = __package__.partition(".")[0]
_LOG = logging.getLogger(_PACKAGE)

_AGAIN = "pip install --force-reinstall --no-deps --no-cache-dir twistarm (or . in a checkout)"


def core() -> ModuleType | None:
    """The compiled core, typed in _core.pyi, or None. `why_not` gives the reason."""
    return _found()[0]


def why_not() -> str:
    """One line with the reason for a missing core and the remedy; empty with a core."""
    return _found()[1]


def need(what: str) -> ModuleType:
    """The compiled core. Without it raise TwistarmError, which names `what` and the remedy."""
    module = core()
    if module is None:
        raise TwistarmError(f"{what} needs the compiled core: {why_not()}")
    return module


def asked(name: str, *given: object) -> Any:
    """The answer of a function of the core; None without a core, or if Python must check the input."""
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
    return module.Chain(screws, home, A, *limits, *starts, reach, *rounding)


def servo_of(arrays: tuple[Array, ...], length: float, below: float, damping: float, stops: bool) -> Servo:
    """The servo of an arm in the core, from what `_core.Servo` takes. TwistarmError as for `need`, or for its size."""
    module, most = need("the servo"), max(max(array.shape) for array in arrays[2:5])
    if most > MOST_JOINTS:
        raise TwistarmError(f"the servo drives at most {MOST_JOINTS} joints or motors; this arm has {most}")
    return module.Servo(*arrays, length, below, damping, stops)


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
