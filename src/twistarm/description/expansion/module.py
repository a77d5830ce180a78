"""A private copy of PyPI's xacro, also in a ROS shell with another one.

xacro keeps its state in module globals, and the confinement replaces functions of it. The program's `xacro` stays
unchanged.
"""

from __future__ import annotations

import functools
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from importlib import import_module
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from typing import Any

from ...support.errors import TwistarmError
from ...support.wheels import Wheel, load

_WHEEL = Wheel("xacro", "xacro", has="process_file", oldest="2.1")
"""ROS 2's is the same code and serves; ROS 1's lacks what `hooked` replaces."""

_NAME = f"{__package__}._xacro"


@functools.cache
def own_xacro() -> Any:
    """The copy, loaded once. Raises TwistarmError in one line, with the remedy, if xacro cannot be used."""
    file = Path(load(_WHEEL).__file__)
    spec = spec_from_file_location(_NAME, file, submodule_search_locations=[str(file.parent)])
    if spec is None or spec.loader is None:
        raise TwistarmError(f"{file} cannot be loaded; pip install xacro==2.1.1")
    copy = sys.modules[_NAME] = module_from_spec(spec)  # where its own imports look for it
    spec.loader.exec_module(copy)
    import_module(f"{_NAME}.substitution_args")
    return copy


@contextmanager
def hooked(module: Any, values: Mapping[str, Any]) -> Iterator[None]:
    """Replace attributes of a module of the copy for a while. Raises TwistarmError if one is missing."""
    missing = [name for name in values if not hasattr(module, name)]
    if missing:
        lacks = f"this xacro ({module.__file__}) has no {', '.join(missing)} and cannot be confined"
        raise TwistarmError(f"{lacks}; pip install xacro==2.1.1")
    original = {name: getattr(module, name) for name in values}
    vars(module).update(values)
    try:
        yield
    finally:
        vars(module).update(original)
