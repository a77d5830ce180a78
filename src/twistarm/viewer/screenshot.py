"""Pictures and prints without a display: an installed browser, run headless, draws a saved page into a file."""

from __future__ import annotations

import io
import operator
import os
import shutil
import signal
import subprocess
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from pathlib import Path

from numpy.typing import ArrayLike

from ..arm.arm import Arm
from ..planning.trajectory import Trajectory
from ..support.errors import InputError, TwistarmError, quote
from ..support.files import writable, write_whole
from .parts.arm_data import loading_findings
from .parts.player import NO_PLOTS
from .saved_page import SceneSnapshot, of_arm, stand_alone

BROWSERS = (
    "chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "microsoft-edge", "microsoft-edge-stable",
    "/snap/bin/chromium",
    "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
    "/Applications/Chromium.app/Contents/MacOS/Chromium",
    "/Applications/Microsoft Edge.app/Contents/MacOS/Microsoft Edge",
)  # fmt: skip
"""Browsers on PATH, and where they are installed without being on it, in the order in which they are tried."""

FLAGS = (
    "--headless",
    # The page is ours, holds numbers and escaped names, and may load nothing; containers and root have no sandbox.
    "--no-sandbox",
    "--disable-gpu", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
    "--no-first-run", "--disable-breakpad", "--disable-quic", "--disable-background-networking",
    "--disable-component-update", "--disable-sync", "--password-store=basic", "--use-mock-keychain",
    "--disable-features=WebUIOmniboxPopup,WebUIOmniboxAimPopup",  # pages of the address bar, which nobody sees
    "--hide-scrollbars", "--force-device-scale-factor=1",
)  # fmt: skip

# [ms] of the page's own time, which stands still while its scripts work: the camera and the floor come in frames.
BUDGET = "--virtual-time-budget=2000"
TIMEOUT = 60.0  # Most seconds for a picture or print. Software rendering of 4096 × 4096 pixels takes some 12 s.


def find_browser() -> str:
    """Find the first of `BROWSERS`. Raises TwistarmError without one."""
    found = next(filter(None, map(shutil.which, BROWSERS)), None)
    if found is None:
        raise TwistarmError(
            "a picture or print needs Chromium, Chrome or Edge, and none of them is on PATH or in /Applications; "
            "install one (on Debian: apt install chromium), or open the page yourself (view -o FILE.html, guide -o DIR)"
        )
    return found


@contextmanager
def browser_at_work(doing: str) -> Iterator[tuple[str, Path]]:
    """An installed browser, and a temporary folder that it can read, for `doing`, such as "draw".

    Raises TwistarmError without a browser, or where the folder cannot be used.
    """
    browser = find_browser()
    try:
        # A snap sees neither /tmp nor hidden folders, but what is below the home folder. It is a link to `snap`, or
        # Ubuntu's wrapper script.
        real = Path(browser).resolve()
        with real.open("rb") as program:
            snap = real.name == "snap" or real.is_relative_to("/snap") or b"/snap/bin/" in program.read(4096)
        home = Path.home() if snap else None
        with tempfile.TemporaryDirectory(prefix="twistarm-", dir=home, ignore_cleanup_errors=True) as folder:
            yield browser, Path(folder)
    except OSError as error:
        raise TwistarmError(f"cannot {doing} with {browser}: {error}") from error


def draw(browser: str, page: Path, size: tuple[int, int]) -> bytes:
    """The PNG that `browser` makes of `page`. The file counts, not how the browser ends: some linger after writing."""
    picture = page.with_name("arm.png")
    window = "--window-size={},{}".format(*size)
    data, end = _run(browser, page, picture, window, f"--screenshot={picture}", place="#pane")
    if wrong := fault(data, size) if data else f"{end} and wrote no picture":
        raise TwistarmError(f"{browser} {wrong}")
    return data


def printed(browser: str, page: Path) -> bytes:
    """The PDF that `browser` prints of `page`, without its own head and foot."""
    paper = page.with_name("page.pdf")
    data, end = _run(browser, page, paper, "--no-pdf-header-footer", f"--print-to-pdf={paper}")
    if not (data.startswith(b"%PDF-") and data.rstrip().endswith(b"%%EOF")):
        raise TwistarmError(f"{browser} {end} and printed no whole PDF")
    return data


def _run(browser: str, page: Path, made: Path, *options: str, place: str = "") -> tuple[bytes, str]:
    """Have `browser` open `page` for at most `TIMEOUT`. None of its processes lives on.

    Returns the content of the file `made`, empty without one, and how the browser ended.
    """
    profile = f"--user-data-dir={page.with_name('profile')}"
    # Debian's launcher makes a folder in the configuration, whatever profile it is given.
    own = {"XDG_CONFIG_HOME": str(page.parent), "XDG_CACHE_HOME": str(page.parent)}
    process = subprocess.Popen(
        (browser, *FLAGS, BUDGET, profile, *options, f"{page.as_uri()}{place}"),
        stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        env={**os.environ, **own}, start_new_session=True,  # a group, which killpg ends with all its children
    )  # fmt: skip
    try:
        end = f"ended with code {process.wait(TIMEOUT)}"
    except subprocess.TimeoutExpired:
        end = f"was ended after {TIMEOUT:g} s"
    finally:
        # macOS refuses a group whose processes are all dead.
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()
    return made.read_bytes() if made.is_file() else b"", end


def fault(data: bytes, size: tuple[int, int]) -> str | None:
    """What is wrong with a picture that should be a PNG of `size` with something in it."""
    from PIL import Image

    try:
        with Image.open(io.BytesIO(data), formats=["PNG"]) as picture:
            pixels = picture.convert("RGB")
    except (OSError, SyntaxError):
        return "wrote a picture that is not a whole PNG"
    if pixels.size != size:
        return "drew {} x {} pixels instead of {} x {}".format(*pixels.size, *size)
    if pixels.getcolors(1):
        return "drew an empty page, as without WebGL; update it, or save the page (-o FILE.html) and open that"
    return None


# Sides of a picture [pixels]. In smaller ones the legend hides the arm. Larger ones may be scaled down.
SMALLEST, LARGEST = 200, 4096


def save_png(
    arm: Arm,
    path: str | os.PathLike[str],
    theta: ArrayLike | None = None,
    *,
    size: tuple[int, int] = (1280, 720),
    trajectory: Trajectory | None = None,
) -> Path:
    """Write a PNG of `arm` at theta (n,) [rad, m], `size` (width, height) in pixels, without a display.

    Chromium, Chrome or Edge must be installed. It draws the 3D view of the `save_html` page without a GPU, with a
    temporary profile. The file is written whole or not at all.

    Returns the path. Raises InputError for a size, theta or path that cannot be used. Raises MissingExtraError without
    Meshcat, and TwistarmError without a browser or if it does not draw.

    Args:
        arm: The arm.
        path: The file to write, which ends in .png.
        theta: The configuration to show (n,) [rad, m]. By default the trajectory's start, else `arm.ready`.
        size: (width, height) [pixels].
        trajectory: A motion, to draw the path of its tool, or None.
    """
    start = trajectory(0.0) if trajectory is not None and theta is None else theta
    return write_picture(path, size, lambda: of_arm(arm, trajectory, start))


def write_picture(path: str | os.PathLike[str], size: tuple[int, int], show: Callable[[], SceneSnapshot]) -> Path:
    """`save_png` of what `show` returns. `show` is called after all checks."""
    target = writable(path)
    if target.suffix.lower() != ".png":
        raise InputError(f"cannot write {target}: a screenshot is a PNG; give a name that ends in .png")
    return write_whole(target, png_of(size, show))


def png_of(size: tuple[int, int], show: Callable[[], SceneSnapshot]) -> bytes:
    """The picture that `write_picture` writes. Findings are hidden, so the doctor does not run."""
    try:
        width, height = map(operator.index, size)
    except (TypeError, ValueError):
        width = height = 0
    if not (SMALLEST <= width <= LARGEST and SMALLEST <= height <= LARGEST):
        wanted = f"width and height in whole pixels, {SMALLEST} to {LARGEST} each, as (1280, 720)"
        raise InputError(f"size must be {wanted}; got {quote(size)}")
    with browser_at_work("draw") as (browser, folder):
        snapshot = show()
        plain = snapshot.with_messages(NO_PLOTS, {**loading_findings(snapshot.arm), "note": ""})
        page = stand_alone(replace(plain, motion=None), zipped=False)
        # Windows have a minimal width and frames: the page itself has this size.
        style = f"<style>body {{ width: {width}px; height: {height}px; }}</style>\n</head>"
        return draw(browser, write_whole(folder / "arm.html", page.replace("</head>", style, 1)), (width, height))
