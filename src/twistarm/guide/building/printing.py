"""A lesson printed: its page as a PDF, by an installed browser."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

from ...viewer.screenshot import browser_at_work, printed

SOLUTION = r"<details[^>]*><summary>Show a solution</summary>.*?</details>"
"""The model solution of an exercise in a page."""


def pdf_of(site: Path, lesson: str, solutions: bool = True) -> bytes:
    """The PDF of a lesson of the site in `site`, unfolded. Without `solutions` it is a sheet for a class.

    Raises TwistarmError without a browser, or if it prints nothing.
    """
    with browser_at_work("print") as (browser, folder):
        page = folder / f"{lesson}.html"
        shutil.copytree(site / "assets", folder / "assets")
        text = (site / page.name).read_text("utf-8")
        if not solutions:
            text = re.sub(SOLUTION, "", text, flags=re.DOTALL)
        # On paper nothing can be unfolded, tried or opened.
        text = re.sub(r"<iframe .*?</iframe>", "", text.replace("<details", "<details open"), flags=re.DOTALL)
        page.write_text(re.sub(r"<script .*?</script>", "", text, flags=re.DOTALL), "utf-8")
        return printed(browser, page)
