"""The view: an arm in the browser, live, as a stand-alone page or as a picture, drawn by Meshcat."""

from .export import save_html
from .screenshot import save_png
from .viewer import Viewer, show_in_browser

__all__ = ["Viewer", "save_html", "save_png", "show_in_browser"]
