"""`view` and `demo`: the arm in the browser, as a stand-alone page, a picture or a film."""

from __future__ import annotations

import re
import sys
from contextlib import ExitStack
from pathlib import Path
from typing import Annotated, TextIO

import numpy as np
import typer

from ...arm.loading.load import load_arm
from ...checking.crosscheck import crosscheck
from ...collision import Scene
from ...ik import Approach, solve_ik
from ...planning import plan_joint
from ...support.errors import InputError
from ...sweeps import ReachMap
from ...viewer import Viewer, page_html, save_html
from ...viewer.files.film import webm_of
from ...viewer.files.scene_snapshot import of_arm
from ...viewer.files.screenshot import png_of
from ...viewer.server.watching import loaded
from ..asked_motion import motion_of_file
from ..options import CONFIGURATION, ArmArgument, Json, Radians, SceneFile, Source
from ..output import progress_bar, say, warn
from ..outputs import Force, Format, Outputs, outputs_of, repeated
from ..quantities import whole
from ..tables import jacobian_table, pose_table
from ..typed import parse_theta
from .arms import show_arm
from .checking import comparisons, verdict
from .inverse import show_solution
from .kinematics import warn_outside
from .motion import plan_tables

Port = Annotated[
    int, whole(0, 65535, "Port to serve on; 0 takes a free one. Any other keeps the recorded poses for next time.")
]
Host = Annotated[str, typer.Option(help="Interface to serve on; anything else opens the view to that network.")]
Output = Annotated[
    list[str] | None,
    repeated(
        "Write a stand-alone page (*.html), a picture (*.png) or a film of --play (*.webm) instead; - is standard "
        "output"
    ),
]
FrameRate = Annotated[int | None, whole(1, 120, "Frames of the film in a second; 30.")]
Play = Annotated[
    Path | None,
    typer.Option(metavar="FILE", help="Play a motion that `twistarm plan` wrote, or that of a motion.toml."),
]
Reach = Annotated[Path | None, typer.Option(metavar="FILE.npz", help="Draw a map that `twistarm reach` wrote.")]
Watch = Annotated[bool, typer.Option("--watch", help="Load the arm again whenever one of its files changes.")]
Browser = Annotated[
    bool,
    typer.Option(
        "--browser/--no-browser",
        help="Open the page in a browser; on a computer that others use too, paste the address instead.",
    ),
]

KINDS = {"html": (".html", ".htm"), "png": (".png",), "webm": (".webm",)}

FILE_INSTEAD = ", or use -o FILE.html for a page that needs no server"


def view(
    source: ArmArgument,
    beside: Annotated[
        Source | None, typer.Argument(metavar="[ARM]", parser=Source, help="Another arm to compare with it.")
    ] = None,
    theta: Annotated[str | None, CONFIGURATION] = None,
    play: Play = None,
    scene: SceneFile = None,
    reach: Reach = None,
    watch: Watch = False,
    port: Port = 0,
    host: Host = "127.0.0.1",
    browser: Browser = True,
    output: Output = None,
    form: Format = None,
    force: Force = False,
    size: Annotated[str | None, typer.Option(metavar="WxH", help="Pixels of picture and film; 1280x720.")] = None,
    frame_rate: FrameRate = None,
    rad: Radians = False,
    json: Json = False,
) -> None:
    """Show the arm in the browser: move, drag, jog, record poses, see its screws. Serves until Ctrl-C."""
    out = outputs_of(output, KINDS, form, force=force, json=json, radians=rad)
    written = {kind for kind, _ in out.files}
    for name, given, kinds in (
        ("--size", size is not None, "png webm"),
        ("--frame-rate", frame_rate is not None, "webm"),
        ("--json", json, "html png webm"),
    ):
        if given and written.isdisjoint(kinds.split()):
            raise InputError(f"{name} goes with -o FILE.{' or -o FILE.'.join(kinds.split())}")
    pixels = _pixels(size or "1280x720")
    arm, files = loaded(source.load)
    x = None if theta is None else parse_theta(arm, theta, rad)
    if x is not None:
        warn_outside(arm, x, rad)
    motion = None if play is None else motion_of_file(arm, play, {})[1]
    reached = None if reach is None else ReachMap.load(reach).require(arm)
    for name, given in (("--scene", scene is not None), ("--reach", reach is not None), ("--watch", watch)):
        if out.files and given:
            raise InputError(f"{name} is for a page that is served: it does not go with -o FILE")
    if beside is not None and (out.files or watch):
        raise InputError("a second ARM is for a page that is served: it does not go with -o FILE or --watch")
    if out.files:
        start = x if motion is None else motion(0.0)

        def film() -> bytes:
            with progress_bar("filming") as progress:
                return webm_of(arm, motion, pixels, frame_rate or 30, progress)

        out.show(
            {"arm": arm, "duration": motion and motion.duration},
            files={
                "html": lambda: page_html(arm, x, trajectory=motion),
                "png": lambda: png_of(pixels, lambda: of_arm(arm, motion, start)),
                "webm": film,
            },
        )
        return
    obstacles = None if scene is None else Scene.load(arm, scene)
    other = None if beside is None else beside.load()
    with ExitStack() as stack:
        viewer = Viewer(arm, x, host=host, port=port, open_browser=False, keep=port != 0, scene=obstacles, beside=other)
        stack.enter_context(viewer)
        if motion is not None:
            viewer.show_path(motion)
            viewer.play(motion)
        if reached is not None:
            viewer.show_reach(reached)
        if watch:
            viewer.watch(source.load, files, lambda words: say(words, file=sys.stderr))
        show_address(viewer, browser, instead=FILE_INSTEAD)
        viewer.wait()


def _pixels(text: str) -> tuple[int, int]:
    """Width and height typed as 1280x720."""
    sides = re.fullmatch(r"\s*(\d{1,6})\s*[xX×]\s*(\d{1,6})\s*", text)
    if sides is None:
        raise InputError(f"--size takes width and height in pixels, as in --size 1280x720; got {text!r}")
    return int(sides[1]), int(sides[2])


def show_address(
    viewer: Viewer, browser: bool, out: TextIO | None = None, *, what: str = "", assumed: str = "", instead: str = ""
) -> None:
    """Print the page's address on `out`, and open it in a browser if wanted.

    `assumed` tells the limits that were not given. `instead` tells what helps where no browser is found.
    """
    if assumed:
        say(f"{assumed} (--velocity, --acceleration)", file=out)
    for note in viewer.notes:
        warn(note)
    say(f"{what or viewer.arm.name} at {viewer.url}  (Ctrl-C ends it)", file=out)
    if browser and not viewer.open_page():
        warn(f"no browser found here; open the address yourself{instead}")


View = Annotated[bool, typer.Option("--view/--no-view", help="Open the view, or write demo.html and demo.csv anew.")]


def demo(view: View = True, port: Port = 0, browser: Browser = True) -> None:
    """Load the bundled rover arm and show FK, Jacobians, cross-check, IK, a trajectory, and the view."""
    out = Outputs()
    arm = load_arm("rover_arm")
    say("1. The arm, from xacro", "")
    show_arm(out, arm)
    say("", "2. Forward kinematics and Jacobians at the ready pose", "")
    g = arm.fk(arm.ready)
    spatial = jacobian_table(arm, "spatial Jacobian", arm.spatial_jacobian(arm.ready))
    body = jacobian_table(arm, "body Jacobian", arm.body_jacobian(arm.ready))
    out.show({}, pose_table(f"{arm.tip} seen from {arm.base}", g, False), "", spatial, "", body)
    say("", "3. The screw view proven against Pinocchio and yourdfpy", "")
    result = crosscheck(arm).require()
    out.show({}, verdict(result), *comparisons(result))
    say("", "4. Inverse kinematics: 0.1 m sideways and 0.1 m up, the tool pointing as before", "")
    solution = solve_ik(arm, Approach(g[:3, 3] + [0.0, 0.1, 0.1], g[:3, 2]))
    show_solution(out, arm, solution)
    if not solution.converged:
        raise InputError("the demo's target was not reached: please report it")
    say("", "5. A trajectory through three poses: stowed, ready, and that target", "")
    through = np.array([arm.named_states["stowed"], arm.ready, solution.theta])
    trajectory = plan_joint(arm, through, kind="quintic")
    out.show({}, *plan_tables(arm, trajectory, arm.limits))
    if not (view and sys.stdout.isatty()):
        say("", f"written: {save_html(arm, Path('demo.html'), trajectory=trajectory)} (opens in a browser, offline)")
        say(f"written: {trajectory.to_csv('demo.csv')}")
        return
    with Viewer(arm, trajectory(0.0), port=port, open_browser=False, keep=port != 0) as viewer:
        viewer.play(trajectory, loop=True)
        show_address(viewer, browser, what="The arm plays it", instead=FILE_INSTEAD)
        viewer.wait()
