"""The course: its lessons in order, and the lesson for each section of the guide."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from ..support.errors import unknown_name

FOLDER = Path(__file__).parent / "lessons"


class Part(NamedTuple):
    """A chapter of the guide and its lessons, by the names of their files."""

    title: str
    lessons: tuple[str, ...]


PARTS = (
    Part("2.1 Rotations", ("2_1_1_rotation_matrices", "2_1_1_quaternions", "2_1_2_exponential_rotations")),
    Part("2.2 Rigid motions", ("2_2_1_rigid_motions", "2_2_2_twists_and_screws")),
    Part("2.3 Velocities", ("2_3_velocities",)),
    Part("3 Joints", ("3_0_joint_types",)),
    Part("3.1 Forward kinematics", ("3_1_forward_kinematics", "3_1_workspace")),
    Part("3.2 Inverse kinematics", ("3_2_two_link_arm", "3_2_all_solutions", "3_2_numeric_solvers")),
    Part("3.3 Motion", ("3_3_1_trajectories", "3_3_2_jacobian", "3_3_2_singularities")),
    Part("4 Your arm", ("4_capstone", "4_calibration")),
)

# The names of the lessons, in the order of the course.
LESSONS = tuple(name for part in PARTS for name in part.lessons)
# The lesson beside the course: errors of the team's guide, each with a number computed in it.
ERRATA = "errata"

SECTIONS = (
    ("2.1.1", "Rotation matrices, Euler angles, where they fail", "2_1_1_rotation_matrices"),
    ("2.1.1", "Quaternions", "2_1_1_quaternions"),
    ("2.1.2", "The group SO(3), exponential coordinates", "2_1_2_exponential_rotations"),
    ("2.1.3", "Rotation in use", "2_1_2_exponential_rotations"),
    ("2.2.1", "Rigid motions in homogeneous form", "2_2_1_rigid_motions"),
    ("2.2.2", "Twists, screws, exponential coordinates", "2_2_2_twists_and_screws"),
    ("2.2.3", "Rigid motion in use", "2_2_1_rigid_motions"),
    ("2.3", "Velocity, Adjoint, wrenches", "2_3_velocities"),
    ("3", "The six joint types", "3_0_joint_types"),
    ("3.1", "Forward kinematics, product of exponentials", "3_1_forward_kinematics"),
    ("3.1", "Workspace, reachable and dextrous", "3_1_workspace"),
    ("3.2", "Inverse kinematics of the two-link arm", "3_2_two_link_arm"),
    ("3.2", "Subproblems, all solutions", "3_2_all_solutions"),
    ("3.2", "Numeric inverse kinematics", "3_2_numeric_solvers"),
    ("3.3.1", "Trajectories", "3_3_1_trajectories"),
    ("3.3.2", "The manipulator Jacobian, statics", "3_3_2_jacobian"),
    ("3.3.2", "Singularities, manipulability", "3_3_2_singularities"),
    ("4", "Building a manipulator", "4_capstone"),
    ("4", "What is true of your arm", "4_calibration"),
)
"""The guide's sections, what is in each, and the lesson that teaches it."""


def lesson_file(name: str) -> Path:
    """Where a lesson lies."""
    return FOLDER / f"{name}.py"


def lesson_named(typed: str) -> str:
    """The lesson of a name or a file. Raises UnknownNameError with the closest names."""
    name = Path(typed).name.removesuffix(".py").removesuffix(".html")
    if name not in LESSONS:
        listing = f"{len(LESSONS)} lessons: {', '.join(LESSONS)}"
        raise unknown_name("lesson", typed, LESSONS, within="the guide", listing=listing)
    return name
