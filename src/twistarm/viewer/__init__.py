"""The view: an arm in the browser, live, in a saved page or a picture. Meshcat draws it."""

from .files.inline import Inline
from .files.page_export import page_html, save_html
from .files.screenshot import save_png
from .viewer import Viewer

__all__ = ["Inline", "Viewer", "page_html", "save_html", "save_png"]
