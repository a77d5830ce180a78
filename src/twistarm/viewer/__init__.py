"""The view: an arm in the browser, live, in a saved page or a picture. Meshcat draws it."""

from .parts.custom import Control, Draw
from .saved_page import Inline, page_html, save_html
from .screenshot import save_png
from .site import save_site
from .viewer import Viewer

__all__ = ["Control", "Draw", "Inline", "Viewer", "page_html", "save_html", "save_png", "save_site"]
