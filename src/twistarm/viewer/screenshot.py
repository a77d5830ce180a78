"""A picture of the arm without a display: an installed browser draws the stand-alone page, headless."""

from __future__ import annotations

import operator
import os
import shutil
import signal
import struct
import subprocess
import tempfile
import zlib
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from numpy.typing import ArrayLike

from ..arm import Arm
from ..errors import InputError, TwistarmError, one_line
from ..files import writable, write_whole
from .export import save_html

NAMES = (
    "chromium",
    "chromium-browser",
    "google-chrome",
    "google-chrome-stable",
    "microsoft-edge",
    "microsoft-edge-stable",
)
"""Browsers on PATH, in the order in which they are tried."""

PLACES = (
    "/snap/bin/chromium",
    "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
    "/Applications/Chromium.app/Contents/MacOS/Chromium",
    "/Applications/Microsoft Edge.app/Contents/MacOS/Microsoft Edge",
)
"""Where they are installed without being on PATH."""

FLAGS = (
    "--headless",
    # The page is ours, holds numbers and escaped names, and may load nothing; containers and root have no sandbox.
    "--no-sandbox",
    "--disable-gpu",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--no-first-run",
    "--disable-breakpad",
    "--disable-quic",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--password-store=basic",
    "--use-mock-keychain",
    "--hide-scrollbars",
    "--force-device-scale-factor=1",
    # [ms] of the page's own time, which stands still while its scripts work: the camera and the floor come in frames.
    "--virtual-time-budget=2000",
)

TIMEOUT = 60.0
"""How long a browser may take [s]; software rendering of 4096 x 4096 pixels takes some 12 s."""

SMALLEST, LARGEST = 200, 4096
"""Sides of a picture [pixels]: below, the legend hides the arm; above, a canvas may be scaled down without a word."""

FEWEST_VALUES = 16
"""A picture of one colour has fewer different bytes, its rows being differences: filter, first pixel, zeros."""


def save_png(
    arm: Arm,
    path: str | os.PathLike[str],
    theta: ArrayLike | None = None,
    *,
    size: tuple[int, int] = (1280, 720),
) -> Path:
    """Write a picture of `arm` at theta (n,) [rad, m] as PNG, `size` (width, height) in pixels; no display is needed.

    `theta` defaults to the ready pose. Chromium, Chrome or Edge must be installed; it draws the page of `save_html`,
    the 3D view alone, without a GPU and with a profile that is thrown away. Written whole or not at all.

    Raises InputError for a bad size, theta or path, MissingExtraError without Meshcat, TwistarmError where there is no
    browser or it does not draw.
    """
    wanted = _checked_size(size)
    target = writable(path)
    if target.suffix.lower() != ".png":
        raise InputError(f"cannot write {target}: a screenshot is a PNG; give a name that ends in .png")
    browser = find_browser()
    # A snap sees neither /tmp nor hidden folders, but what is below the home folder.
    home = Path.home() if is_snap(browser) else None
    try:
        with tempfile.TemporaryDirectory(prefix="twistarm-", dir=home, ignore_cleanup_errors=True) as folder:
            page = _page(arm, Path(folder, "arm.html"), theta, wanted)
            picture = _draw(browser, page, wanted)
    except OSError as error:
        raise TwistarmError(f"cannot draw with {browser}: {error}") from error
    return write_whole(target, picture)


def find_browser() -> str:
    """The first of `NAMES` on PATH, else of `PLACES`; TwistarmError where there is none."""
    found = next(filter(None, map(shutil.which, (*NAMES, *PLACES))), None)
    if found is None:
        raise TwistarmError(
            f"a screenshot needs a browser, and there is none of {', '.join(NAMES)} on PATH, nor Chrome, Chromium or "
            "Edge in /Applications; install one (on Debian: apt install chromium), or save the page (save_html, --save)"
        )
    return found


def is_snap(browser: str) -> bool:
    """Whether this is a snap: a link to `snap`, or the script that Ubuntu installs in its place."""
    real = Path(browser).resolve()
    if real.name == "snap" or real.is_relative_to("/snap"):
        return True
    with suppress(OSError), real.open("rb") as file:
        return b"/snap/bin/" in file.read(4096)
    return False


def _checked_size(size: tuple[int, int]) -> tuple[int, int]:
    try:
        width, height = map(operator.index, size)
    except (TypeError, ValueError):
        width = height = 0
    if not (SMALLEST <= width <= LARGEST and SMALLEST <= height <= LARGEST):
        raise InputError(
            f"size must be width and height in whole pixels, {SMALLEST} to {LARGEST} each, as (1280, 720); got {size!r}"
        )
    return width, height


def _page(arm: Arm, path: Path, theta: ArrayLike | None, size: tuple[int, int]) -> Path:
    """The stand-alone page, of this very size: a window has a least width, and in some browsers a frame."""
    page = save_html(arm, path, theta=theta)
    style = "<style>body {{ width: {}px; height: {}px; }}</style>\n</head>".format(*size)
    return write_whole(page, page.read_text("utf-8").replace("</head>", style, 1))


def _draw(browser: str, page: Path, size: tuple[int, int]) -> bytes:
    """The PNG that `browser` makes of `page`. The file counts, not how the browser ends: some linger after writing."""
    picture = page.with_name("arm.png")
    command = (
        browser,
        *FLAGS,
        f"--user-data-dir={page.with_name('profile')}",
        "--window-size={},{}".format(*size),
        f"--screenshot={picture}",
        f"{page.as_uri()}#pane",
    )
    end = _run(command, page.parent)
    data = picture.read_bytes() if picture.is_file() else b""
    fault = _fault(data, size) if data else f"{end} and wrote no picture"
    if fault:
        raise TwistarmError(f"{browser} {fault}")
    return data


def _run(command: tuple[str, ...], folder: Path) -> str:
    """Run `command` for at most `TIMEOUT`, and say how it ended; none of its processes outlives this call."""
    # Debian's launcher makes a folder in the configuration, whatever profile it is given.
    own = {"XDG_CONFIG_HOME": str(folder), "XDG_CACHE_HOME": str(folder)}
    log = folder / "log"
    with log.open("wb") as output:
        process = subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            stdout=output,
            stderr=output,
            env={**os.environ, **own},
            start_new_session=True,
        )
    try:
        code = process.wait(TIMEOUT)
    except subprocess.TimeoutExpired:
        return f"was ended after {TIMEOUT:g} s"
    finally:
        # macOS refuses a group whose processes are all dead.
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()
    said = log.read_text("utf-8", errors="replace").strip().rpartition("\n")[2]
    return f"ended with code {code}" + (f" ({one_line(said, 200)})" if said else "")


def _fault(data: bytes, size: tuple[int, int]) -> str | None:
    """What is wrong with a picture that should be a PNG of `size` with something in it."""
    try:
        if data[:8] != b"\x89PNG\r\n\x1a\n":
            raise ValueError("signature")
        chunks = list(_chunks(data))
        found = struct.unpack(">II", chunks[0][1][:8])
        pixels = zlib.decompress(b"".join(content for kind, content in chunks if kind == b"IDAT"))
    except (ValueError, IndexError, struct.error, zlib.error):
        return "wrote a picture that is not a whole PNG"
    if found != size:
        return "drew {} x {} pixels instead of {} x {}".format(*found, *size)
    if len(set(pixels)) < FEWEST_VALUES:
        return "drew an empty page, as without WebGL; update it, or save the page (save_html, --save) and open that"
    return None


def _chunks(data: bytes) -> Iterator[tuple[bytes, bytes]]:
    """Type and content of each part of a PNG up to its end (PNG specification, 5.3); struct.error where it is cut."""
    at, kind = 8, b""
    while kind != b"IEND":
        length, kind = struct.unpack_from(">I4s", data, at)
        yield kind, data[at + 8 : at + 8 + length]
        at += 12 + length
