"""twistarm: the kinematics of robot arms in the language of screws.

Conventions, everywhere: SI units and radians; `theta` (..., n) is one number per degree of freedom, base to tip; a
pose `g_ab` (..., 4, 4) is frame b seen from frame a, p_a = g_ab @ p_b; a twist is (v, w), linear part first, as in
Murray, Li & Sastry and in Pinocchio; s is the space frame (the base link), t the tool frame (the tip link).

The public names stand in `__init__.pyi`. Each is imported when it is first asked for, so that a program heeds Ctrl-C
from its first line on.
"""

from __future__ import annotations

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

__version__ = "0.1.0"


def _public_names() -> dict[str, str]:
    """{name: the module that it comes from}, as `__init__.pyi` has them, a line each."""
    with open(f"{__file__}i", encoding="utf-8") as stub:
        lines = [line.split() for line in stub if line.startswith("from ")]
    return {name: module for _, module, _, name, *_ in lines}


_MODULES = _public_names()

__all__ = sorted(_MODULES)


def __getattr__(name: str) -> Any:
    from importlib import import_module

    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}", name=name)
    module = _MODULES[name]
    home = None if module == "." else import_module(module, __name__)
    # What is no attribute of its package is a module in it.
    value = getattr(home, name) if hasattr(home, name) else import_module(f"{module.rstrip('.')}.{name}", __name__)
    return globals().setdefault(name, value)  # so that this is asked once for each name


def __dir__() -> list[str]:
    return list(__all__)
