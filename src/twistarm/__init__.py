"""twistarm: the kinematics of robot arms in the language of screws.

Conventions, everywhere: SI units and radians. `theta` (..., n) is one number per degree of freedom, base to tip. A
pose `g_ab` (..., 4, 4) is frame b seen from frame a, p_a = g_ab @ p_b. A twist is (v, w), linear part first, as in
Murray, Li & Sastry and in Pinocchio. The space frame s is the base link, the tool frame t the tip link.

The public names are in `__init__.pyi`. Each is imported at its first use, so that `import twistarm` takes milliseconds.
"""

from __future__ import annotations

TYPE_CHECKING = False  # without `typing`, which takes as long to import as all of this
if TYPE_CHECKING:
    from typing import Any

__version__ = "0.1.0"


def _public_names() -> dict[str, str]:
    """{name: the module that it comes from}, read from `__init__.pyi`: a second list would differ one day."""
    with open(f"{__file__}i", encoding="utf-8") as stub:
        lines = [line.split() for line in stub if line.startswith("from ")]
    return {name: module for _, module, _, name, *_ in lines}


_MODULES = _public_names()

__all__ = sorted(_MODULES)


def __getattr__(name: str) -> Any:
    from importlib import import_module

    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}", name=name)
    source = _MODULES[name]
    module = None if source == "." else import_module(source, __name__)
    # A name that is no attribute of its package is a module in it.
    value = getattr(module, name) if hasattr(module, name) else import_module(f"{source.rstrip('.')}.{name}", __name__)
    return globals().setdefault(name, value)  # Python calls __getattr__ only for names that are missing


def __dir__() -> list[str]:
    return list(__all__)
