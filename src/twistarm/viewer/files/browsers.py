"""Installed browsers that can draw for a program: Chromium, Chrome or Edge."""

from __future__ import annotations

import shutil
from contextlib import suppress
from pathlib import Path

from ...support.errors import TwistarmError

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


def find_browser() -> str:
    """Find the first browser of `NAMES` on PATH, then of `PLACES`. Raises TwistarmError without one."""
    found = next(filter(None, map(shutil.which, (*NAMES, *PLACES))), None)
    if found is None:
        raise TwistarmError(
            f"a picture or a print needs a browser, and there is none of {', '.join(NAMES)} on PATH, nor Chrome, "
            "Chromium or Edge in /Applications; install one (on Debian: apt install chromium), or open the page "
            "yourself (view -o FILE.html, guide -o DIR)"
        )
    return found


def is_snap(browser: str) -> bool:
    """Whether this is a snap: a link to `snap`, or Ubuntu's wrapper script."""
    real = Path(browser).resolve()
    if real.name == "snap" or real.is_relative_to("/snap"):
        return True
    with suppress(OSError), real.open("rb") as file:
        return b"/snap/bin/" in file.read(4096)
    return False
