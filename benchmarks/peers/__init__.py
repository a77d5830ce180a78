"""The solvers that are compared, one module each.

A module has a class `Solver(robot)`, made from the robot's message (`robots.Robot`), with

  settings, distributions        a sentence for the footnotes; the distributions whose versions are noted
  solve(g, start)                theta or None, whether it claims to have converged, and what `reason` reads, if any
  batch(targets, starts, threads)   optional: theta (N, n) and converged (N,)
  kinematics()                   optional: {"one" | "unchecked" | "batch": {"fk" | "fk_jacobian": function of theta}}

It raises `Unfit` for an arm that it does not take. Its imports are inside the module. It runs in an environment made
from requirements-<name>.txt, without twistarm.
"""

PEERS = ("twistarm", "pinocchio", "roboticstoolbox", "pytracik", "ssik", "eaik", "placo", "pink")


class Unfit(Exception):  # noqa: N818
    """This solver does not take this arm, and why."""
