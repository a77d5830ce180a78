"""The view: an arm in the browser, live, as a stand-alone page or as a picture, drawn by Meshcat."""

from .export import page_html, save_html
from .inline import Inline
from .screenshot import save_png
from .viewer import Viewer

__all__ = ["Inline", "Viewer", "page_html", "save_html", "save_png"]
