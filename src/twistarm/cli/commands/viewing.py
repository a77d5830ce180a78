"""`view` and `demo`: the arm in the browser, as a stand-alone page or a picture."""

from __future__ import annotations

import re
import sys
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, TextIO

import numpy as np

from ...arm import engine
from ...arm.arm import Arm
from ...collision import Scene
from ...design import ReachMap
from ...support.checks import Array
from ...support.errors import InputError, TwistarmError
from ...viewer import Viewer, page_html
from ...viewer.saved_page import of_arm
from ...viewer.scene.links import missing_meshes
from ...viewer.screenshot import png_of
from ...viewer.server.watching import load_with_files
from ...viewer.site import site_of, write_site
from ..command import Shared
from ..numbers import JointValues, argument, option, switch, whole
from ..options import ArmArgument, SceneFile, Source, Theta, answers
from ..output import Outputs, refuse, say, warn
from ..rows import TypedTargets
from .arms import info
from .checking import check
from .kinematics import fk, ik, jacobian
from .motion import HOW_TO_CHANGE, MOTION_KINDS, motion_of_file, plan

VIEW_KINDS = {"html": (".html", ".htm"), "png": (".png",), "site": ("/",)}

FILE_INSTEAD = ", or use -o FILE.html for a page that needs no server"


@dataclass(frozen=True)
class Page:
    """The options of the page, and the view that serves it."""

    port: Annotated[int, whole(0, 65535, "Port to serve on; 0: a free one.")] = 0
    host: Annotated[str, option(None, "Interface to serve on; anything else opens the view to that network.")] = (
        "127.0.0.1"
    )
    browser: Annotated[
        bool,
        switch(
            "Open the page in a browser; on a computer that others use too, paste the address instead.",
            "--browser/--no-browser",
        ),
    ] = True

    def viewer(self, arm: Arm, theta: Array | None, scene: Scene | None = None, beside: Arm | None = None) -> Viewer:
        """The view, not yet opened in a browser."""
        where: dict[str, Any] = {"host": self.host, "port": self.port, "open_browser": False}
        return Viewer(arm, theta, scene=scene, beside=beside, **where)

    def show_address(
        self, viewer: Viewer, out: TextIO | None = None, *, what: str = "", assumed: str = "", instead: str = ""
    ) -> None:
        """Print the page's address on `out`, and open it in a browser if wanted.

        `assumed` names the limits that were not given. `instead` says what helps where no browser is found.
        """
        if assumed:
            say(f"{assumed} ({HOW_TO_CHANGE})", file=out)
        say(f"{what or viewer.arm.name} at {viewer.url}  (Ctrl-C ends it)", file=out)
        if self.browser and not viewer.open_page():
            warn(f"no browser found here; open the address yourself{instead}")


PageOptions = Annotated[Page, Shared(Page)]

Play = Annotated[Path | None, option("FILE", "Play a motion that `twistarm plan` wrote, or that of a motion.toml.")]
Reach = Annotated[Path | None, option("FILE.npz", "Draw a map that `twistarm reach` wrote.")]
Watch = Annotated[bool, switch("Load the arm again whenever one of its files changes.", "--watch")]
More = Annotated[
    list[Source] | None, argument("[ARM]…", "A second arm to compare with it, or more arms of a site.", parser=Source)
]
Size = Annotated[str | None, option("WxH", "Pixels of the picture; 1280x720.")]
Written = Annotated[
    Outputs,
    answers(
        "output form force rad json",
        VIEW_KINDS,
        output="Write a stand-alone page (*.html), a picture (*.png), or a site of all ARM (FOLDER/) instead; - is "
        "standard output; repeat it.",
    ),
]


def view(
    source: ArmArgument,
    page: PageOptions,
    out: Written,
    more: More = None,
    theta: Theta = None,
    play: Play = None,
    scene: SceneFile = None,
    reach: Reach = None,
    watch: Watch = False,
    size: Size = None,
) -> None:
    """Show the arm in the browser: move, drag, jog, record poses, see its screws. Serves until Ctrl-C."""
    kinds, others = {kind for kind, _ in out.files}, more or []
    site, served = "site" in kinds, {"--scene": scene, "--reach": reach, "--watch": watch or None}
    refuse({
        "--size goes with -o FILE.png": size is not None and "png" not in kinds,
        "--json goes with -o FILE": out.json and not out.files,
        **{f"{name} is for a page that is served: it does not go with -o FILE": out.files and given is not None
           for name, given in served.items()},
        "-o FOLDER/ is a site: it goes with no other -o": site and len(out.files) > 1,
        "--theta and --play are for a page of one arm: they do not go with -o FOLDER/": site and (theta or play),
        "a second ARM goes with -o FOLDER/ alone, which makes a site of all": others and out.files and not site,
        "a page has at most two ARM; -o FOLDER/ makes a site of more": len(others) > 1 and not site,
        "--watch is for one arm: leave out the second ARM": others and watch,
    })  # fmt: skip
    # A site is of many arms, and the rest of this function of one, perhaps with another beside it.
    if site:
        _write_site([source, *others], out)
        return
    sides = re.fullmatch(r"\s*(\d{1,6})\s*[xX×]\s*(\d{1,6})\s*", size or "1280x720")
    if sides is None:
        raise InputError(f"--size takes width and height in pixels, as in --size 1280x720; got {size!r}")
    pixels = int(sides[1]), int(sides[2])
    arm, files = load_with_files(source.load)
    x = None if theta is None else theta.anywhere(arm)
    motion = None if play is None else motion_of_file(arm, play)[1]
    if out.files:
        start = x if motion is None else motion(0.0)
        for note in () if arm.description is None else missing_meshes(arm.description):
            warn(note)
        out.show(
            {"arm": arm, "duration": motion and motion.duration},
            files={
                "html": lambda: page_html(arm, x, trajectory=motion),
                "png": lambda: png_of(pixels, lambda: of_arm(arm, motion, start)),
            },
        )
        return
    # Both are read before the server starts: a wrong file must not open a page.
    reached = None if reach is None else ReachMap.load(reach).require(arm)
    obstacles = None if scene is None else Scene.load(arm, scene)
    with ExitStack() as stack:
        viewer = stack.enter_context(page.viewer(arm, x, obstacles, others[0].load() if others else None))
        if motion is not None:
            viewer.show_path(motion)
            viewer.play(motion)
        if reached is not None:
            viewer.show_reach(reached)
        if watch:
            viewer.watch(source.load, files, lambda words: say(words, file=sys.stderr))
        page.show_address(viewer, instead=FILE_INSTEAD)
        viewer.wait()


def _write_site(sources: Sequence[Source], out: Outputs) -> None:
    """A site of the arms, once all of them are loaded."""
    arms, failed = [], []
    for source in sources:
        try:
            arms.append(source.load())
        except TwistarmError as error:  # noqa: PERF203, all that fail are named
            failed.append(str(error) if source.name in str(error) else f"{source.name}: {error}")
    if failed:
        what = f"nothing is written, since {len(failed)} of {len(sources)} ARM cannot be loaded"
        raise InputError(f"{what}; leave them out, or fix them: twistarm doctor: {'; '.join(failed)}")
    cards, files = site_of(arms, lambda words: say(words, file=out.words))
    [(_, folder)] = out.files
    write_site(folder, files)
    out.show({"arms": cards, "files": list(files)}, written=[folder])


Show = Annotated[bool, switch("Open the view, or write demo.html; demo.csv is written.", "--view/--no-view")]


def demo(page: PageOptions, show: Show = True) -> None:
    """Run commands on the bundled rover arm: info, fk, jacobian, check, ik, plan and view."""
    rover, out, motion = Source("rover_arm"), Outputs(), Path("demo.csv")
    say("1. The arm, from xacro: info rover_arm", "")
    info(out, rover)
    say("", "2. Forward kinematics and Jacobians at the configuration ready: fk, jacobian", "")
    fk(rover, out)
    jacobian(rover, out)
    say("", "3. The screw view proven against Pinocchio and yourdfpy: check", "")
    check(rover, out)
    say("", "4. Inverse kinematics, the tool forwards: ik --xyz 0.7 0.1 0.6 --direction 1 0 0", "")
    p, towards = np.array([0.7, 0.1, 0.6]), np.array([1.0, 0.0, 0.0])
    ik(rover, out, TypedTargets([p], direction=[towards]))
    stop = engine.core() is None  # which times every motion that does not stop at each configuration
    how = " --stop" if stop else ""
    say("", f"5. A motion through three configurations: plan --to stowed --to reach{how} -o demo.csv", "")
    to = [JointValues(name, "--to", radians=False) for name in ("stowed", "reach")]
    plan(rover, Outputs(kinds=MOTION_KINDS, force=True).named(str(motion)), TypedTargets(), to=to, stop=stop)
    watched = show and sys.stdout.isatty()
    say("", f"6. The arm that plays it: view --play demo.csv{'' if watched else ' -o demo.html'}", "")
    view(rover, page, out if watched else Outputs(kinds=VIEW_KINDS, force=True).named("demo.html"), play=motion)
