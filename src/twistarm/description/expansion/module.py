"""The xacro that expands descriptions: PyPI's, also in a ROS shell that stands before it with its own."""

from __future__ import annotations

from typing import Any

from ...wheels import Wheel, load

_WHEEL = Wheel(
    "xacro",
    "xacro",
    # ROS 2's xacro is the same code and serves where it was imported already; ROS 1's asks roslaunch for its arguments.
    needs=("process_file", "all_includes", "substitution_args._eval_find", "substitution_args._eval_dict"),
    oldest="2.1",
)


def import_xacro() -> Any:
    """The module, or a TwistarmError that says what stands before it and how to start."""
    return load(_WHEEL)
