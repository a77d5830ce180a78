"""A lesson printed: its page as a PDF, by an installed browser."""

from __future__ import annotations

import re
import shutil
import tempfile
from pathlib import Path

from ...support.errors import TwistarmError
from ...viewer.files.browsers import find_browser, is_snap
from ...viewer.files.headless import printed

SOLUTION = r"<details[^>]*><summary>Show a solution</summary>.*?</details>"
"""The model solution of an exercise in a page."""


def pdf_of(site: Path, lesson: str, solutions: bool = True) -> bytes:
    """The PDF of a lesson of the site in `site`, unfolded. Without `solutions` it is a sheet for a class.

    Raises TwistarmError without a browser, or if it prints nothing.
    """
    browser = find_browser()
    # A snap of Ubuntu sees no hidden folder and no temporary one.
    home = Path.home() if is_snap(browser) else None
    try:
        with tempfile.TemporaryDirectory(prefix="twistarm-", dir=home, ignore_cleanup_errors=True) as folder:
            page = Path(folder, f"{lesson}.html")
            shutil.copytree(site / "assets", Path(folder, "assets"))
            text = (site / page.name).read_text("utf-8")
            if not solutions:
                text = re.sub(SOLUTION, "", text, flags=re.DOTALL)
            # On paper nothing can be unfolded, tried or opened.
            text = re.sub(r"<iframe .*?</iframe>", "", text.replace("<details", "<details open"), flags=re.DOTALL)
            page.write_text(re.sub(r"<script .*?</script>", "", text, flags=re.DOTALL), "utf-8")
            return printed(browser, page)
    except OSError as error:
        raise TwistarmError(f"cannot print with {browser}: {error}") from error
