"""The view: an arm in the browser, live, in a saved page or a picture. Meshcat draws it."""

from .draw import Draw
from .files.page_export import Inline, page_html, save_html
from .files.screenshot import save_png
from .parts.controls import Control
from .viewer import Viewer

__all__ = ["Control", "Draw", "Inline", "Viewer", "page_html", "save_html", "save_png"]
