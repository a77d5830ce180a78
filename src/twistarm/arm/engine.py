"""The two engines of an arm's kinematics: the compiled core `twistarm._core`, and NumPy where that is missing.

The core takes contiguous float64 arrays, Python's float and int, and values in their ranges. It answers None to
anything else (`solve_batch`: False), and changes nothing. So a fast call passes its arguments unchecked. After None it
checks and converts them, or says what is wrong, and calls again. `answered` takes the answer to checked arguments.
"""

from __future__ import annotations

import importlib
import logging
from functools import cache
from types import ModuleType
from typing import TYPE_CHECKING, Any, TypeVar

from ..support.checks import Array
from ..support.errors import TwistarmError
from ..theory import poe
from ..theory.screws import adjoint_of, exp_along, inverse_of, turn_and_slide

if TYPE_CHECKING:
    from .._core import Chain as Chain
    from .._core import Servo as Servo

T = TypeVar("T")

INTERFACE = 26
"""Version of the compiled core that this Python needs. It rises with each change of a call."""

MOST_JOINTS = 64
"""The most moving joints or coordinates of a chain in the core."""

_PACKAGE = __package__.partition(".")[0]
_LOG = logging.getLogger(_PACKAGE)

_AGAIN = "pip install --force-reinstall --no-deps --no-cache-dir twistarm (in a checkout: make core)"
_LOST = "takes milliseconds instead of microseconds and gives neither the nearest configuration nor the reason"


class NumpyChain:
    """The chain of screws (6, m), home (4, 4) and A (m, n) in NumPy, with kernels of `_core.Chain`.

    g_st(theta) = Π exp(ξ_i (Aθ)_i) · home, MLS §3.2.2, eq. 3.3. The kernels take theta (..., n) and check nothing.
    """

    def __init__(self, screws: Array, home: Array, A: Array) -> None:
        self._screws, self._home, self._A = screws, home, A
        self._terms = turn_and_slide(screws.T)

    def fk(self, theta: Array) -> Array:
        """g_st (..., 4, 4)."""
        return self._motions(theta)[..., -1, :, :] @ self._home

    def spatial_jacobian(self, theta: Array) -> Array:
        """J^s (..., 6, n), linear part first. MLS §3.4.1."""
        return poe.columns(self._motions(theta), self._screws) @ self._A

    def body_jacobian(self, theta: Array) -> Array:
        """J^b (..., 6, n), linear part first. MLS §3.4.1."""
        return self.fk_and_body_jacobian(theta)[1]

    def fk_and_body_jacobian(self, theta: Array) -> tuple[Array, Array]:
        """Both, with the exponentials computed once."""
        moved = self._motions(theta)
        g = moved[..., -1, :, :] @ self._home
        return g, adjoint_of(inverse_of(g)) @ poe.columns(moved, self._screws) @ self._A

    def _motions(self, theta: Array) -> Array:
        return poe.products(exp_along(*self._terms, theta @ self._A.T))


def core() -> ModuleType | None:
    """The compiled core, typed in _core.pyi, or None. `why_not` gives the reason."""
    return _found()[0]


def why_not() -> str:
    """One line with the reason for a missing core and the remedy. Empty with a core."""
    return _found()[1]


def need(what: str) -> ModuleType:
    """The compiled core. Without it raise TwistarmError, which names `what` and the remedy."""
    module = core()
    if module is None:
        raise TwistarmError(f"{what} needs the compiled core: {why_not()}")
    return module


def asked(name: str, *given: object) -> Any:
    """The answer of a function of the core. None without a core, or if Python must check the input."""
    module = core()
    return None if module is None else getattr(module, name)(*given)


def answered(answer: T | None) -> T:
    """The core's answer to arguments that have been checked, which is never None."""
    assert answer is not None, "the core takes what has been checked"
    return answer


def instruction_set() -> str:
    """The instruction set of the core's kernels (avx512, avx2, baseline). Empty without a core."""
    module = core()
    return "" if module is None else str(module.instruction_sets()[0])


def chain_of(
    screws: Array, home: Array, A: Array, limits: tuple[Array, Array], starts: tuple[Array, Array], reach: float
) -> Chain | None:
    """The chain of screws (6, m), home and A (m, n) in the core. None without a core or beyond its size.

    `limits` are the lower and upper bounds (n,), `starts` the finite bounds of random starts. `reach` [m] compares
    metres with radians in a rank.
    """
    module = core()
    if module is None:
        _say_once()
        return None
    if max(A.shape) > MOST_JOINTS:
        _LOG.warning("%d joints exceed the core's %d, so inverse kinematics %s", max(A.shape), MOST_JOINTS, _LOST)
        return None
    return module.Chain(screws, home, A, *limits, *starts, reach)


def servo_of(arrays: tuple[Array, ...], length: float, below: float, damping: float, stops: bool) -> Servo:
    """The servo of an arm in the core, from what `_core.Servo` takes. TwistarmError as for `need`, or for its size."""
    module, most = need("the servo"), max(max(array.shape) for array in arrays[2:5])
    if most > MOST_JOINTS:
        raise TwistarmError(f"the servo drives at most {MOST_JOINTS} joints or motors; this arm has {most}")
    return module.Servo(*arrays, length, below, damping, stops)


@cache
def _say_once() -> None:
    """Log once that everything is slower without the core. The default log is stderr."""
    _LOG.warning("no compiled core, so inverse kinematics %s: %s", _LOST, why_not())


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
