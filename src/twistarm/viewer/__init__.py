"""The view: an arm in the browser, live or as a stand-alone page, drawn by Meshcat."""

from .export import save_html
from .viewer import Viewer, show_in_browser

__all__ = ["Viewer", "save_html", "show_in_browser"]
