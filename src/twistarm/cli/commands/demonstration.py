"""`demo`: every station of the main job on the bundled rover arm."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from rich.console import Console

from ...arm.arm import Arm
from ...arm.loading.load import load_arm
from ...checking.crosscheck import crosscheck
from ...ik import Approach, solve_ik
from ...planning import Trajectory, plan_joint
from ...support.errors import InputError
from ...viewer import Viewer, save_html
from ..output import console, jacobian_table, pose_table, say
from ..wording import words
from .checking import check_table, verdict
from .inspection import info_view
from .inverse import solution_table
from .motion import plan_table
from .viewing import FILE_INSTEAD, Browser, Port, show_address

View = Annotated[bool, typer.Option("--view/--no-view", help="Open the view, or write demo.html and demo.csv anew.")]


def demo(view: View = True, port: Port = 0, browser: Browser = True) -> None:
    """Load the bundled rover arm and show FK, Jacobians, cross-check, IK, a trajectory, and the view."""
    out = console()
    arm = load_arm("rover_arm")
    _show_arm(out, arm)
    trajectory = _show_motion(out, arm)
    if not (view and sys.stdout.isatty()):
        say("", f"written: {save_html(arm, Path('demo.html'), trajectory=trajectory)} (opens in a browser, offline)")
        say(f"written: {trajectory.to_csv('demo.csv')}")
        return
    with Viewer(arm, trajectory(0.0), port=port, open_browser=False, keep=port != 0) as viewer:
        viewer.play(trajectory, loop=True)
        show_address(viewer, browser, what="The arm plays it", instead=FILE_INSTEAD)
        viewer.wait()


def _show_arm(out: Console, arm: Arm) -> None:
    out.rule("1. The arm, from xacro")
    out.print(info_view(arm, radians=False))
    out.rule("2. Forward kinematics and Jacobians at the ready pose")
    out.print(pose_table(f"{arm.tip} seen from {arm.base}", arm.fk(arm.ready), radians=False))
    out.print(jacobian_table(arm, "spatial Jacobian", arm.spatial_jacobian(arm.ready)))
    out.print(jacobian_table(arm, "body Jacobian", arm.body_jacobian(arm.ready)))
    out.rule("3. The screw view proven against Pinocchio and yourdfpy")
    result = crosscheck(arm).require()
    say(verdict(result))
    out.print(check_table(result))


def _show_motion(out: Console, arm: Arm) -> Trajectory:
    out.rule("4. Inverse kinematics: 0.1 m sideways and 0.1 m up, the tool pointing as before")
    g = arm.fk(arm.ready)
    target = Approach(g[:3, 3] + [0.0, 0.1, 0.1], g[:3, 2])
    solution = solve_ik(arm, target)
    out.print(solution_table(arm, solution, radians=False))
    say(*words(solution.explain()).splitlines())
    if not solution.converged:
        raise InputError("the demo's target was not reached: please report it")
    out.rule("5. A trajectory through three poses: stowed, ready, and that target")
    through = np.array([arm.named_states["stowed"], arm.ready, solution.theta])
    trajectory = plan_joint(arm, through, kind="quintic")
    out.print(plan_table(arm, trajectory, radians=False, limits=arm.limits))
    return trajectory
