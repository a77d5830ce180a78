"""`view`: the arm in the browser, as a stand-alone page, a picture or a film."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from typing import Annotated, Any, TextIO

import typer

from ...arm.arm import Arm
from ...arm.loading.load import load_arm
from ...collision import Scene
from ...planning.trajectory import Trajectory
from ...support.errors import InputError
from ...sweeps import ReachMap
from ...viewer import Viewer, page_html
from ...viewer.files.film import webm_of
from ...viewer.files.scene_snapshot import of_arm
from ...viewer.files.screenshot import png_of
from ...viewer.server.watching import loaded
from ..asked_motion import motion_of_file
from ..options import CONFIGURATION, Json, Radians, SceneFile, takes_source
from ..output import print_json, progress_bar, say, warn
from ..outputs import Force, Format, outputs_of, repeated
from ..quantities import whole
from ..typed import parse_theta
from .kinematics import warn_outside

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


@takes_source
def view(
    source: str,
    load: dict[str, Any],
    beside: Annotated[str | None, typer.Argument(metavar="[ARM]", help="Another arm to compare with it.")] = None,
    theta: Annotated[str | None, CONFIGURATION] = None,
    port: Port = 0,
    host: Host = "127.0.0.1",
    browser: Browser = True,
    watch: Watch = False,
    play: Play = None,
    scene: SceneFile = None,
    reach: Reach = None,
    output: Output = None,
    form: Format = None,
    force: Force = False,
    size: Annotated[str | None, typer.Option(metavar="WxH", help="Pixels of picture and film; 1280x720.")] = None,
    frame_rate: FrameRate = None,
    rad: Radians = False,
    json: Json = False,
) -> None:
    """Show the arm in the browser: move, drag, jog, record poses, see its screws. Serves until Ctrl-C."""
    outputs = outputs_of(output, KINDS, form, force=force, json=json)
    written = {kind for kind, _ in outputs.files}
    for name, idle, kinds in (
        ("--size", size is None, "png webm"),
        ("--frame-rate", frame_rate is None, "webm"),
        ("--json", not json, "html png webm"),
    ):
        if not idle and written.isdisjoint(kinds.split()):
            raise InputError(f"{name} goes with -o FILE.{' or -o FILE.'.join(kinds.split())}")
    pixels = _pixels(size or "1280x720")
    load_again = partial(load_arm, source, **load)
    arm, files = loaded(load_again)
    x = None if theta is None else parse_theta(arm, theta, rad)
    if x is not None:
        warn_outside(arm, x, rad)
    motion = None if play is None else motion_of_file(arm, play, {})[1]
    m = None if reach is None else ReachMap.load(reach).require(arm)
    for name, given in {"--scene": scene, "--reach": reach, "--watch": watch or None}.items():
        if outputs.files and given is not None:
            raise InputError(f"{name} is for a page that is served: it does not go with -o FILE")
    if beside is not None and (outputs.files or watch):
        raise InputError("a second ARM is for a page that is served: it does not go with -o FILE or --watch")
    if outputs.files:
        start = x if motion is None else motion(0.0)
        contents: dict[str, Callable[[], str | bytes]] = {
            "html": lambda: page_html(arm, x, trajectory=motion),
            "png": lambda: png_of(pixels, lambda: of_arm(arm, motion, start)),
            "webm": lambda: _film(arm, motion, pixels, frame_rate or 30),
        }
        names = outputs.write(contents)
        if json:
            print_json({"arm": arm.name, "written": names, "duration": motion and motion.duration})
        else:
            outputs.say(names)
        return
    obstacles = None if scene is None else Scene.load(arm, scene)
    other = None if beside is None else load_arm(beside, **load)
    with ExitStack() as stack:
        viewer = Viewer(arm, x, host=host, port=port, open_browser=False, keep=port != 0, scene=obstacles, beside=other)
        stack.enter_context(viewer)
        if motion is not None:
            viewer.show_path(motion)
            viewer.play(motion)
        if m is not None:
            viewer.show_reach(m)
        if watch:
            viewer.watch(load_again, files, lambda words: say(words, file=sys.stderr))
        show_address(viewer, browser, instead=FILE_INSTEAD)
        viewer.wait()


def _film(arm: Arm, motion: Trajectory | None, pixels: tuple[int, int], rate: int) -> bytes:
    with progress_bar("filming") as progress:
        return webm_of(arm, motion, pixels, rate, progress)


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
