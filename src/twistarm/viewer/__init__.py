"""The view: an arm in the browser, live or as a stand-alone page, drawn by Meshcat."""

from .export import save_html
from .viewer import Viewer

__all__ = ["Viewer", "save_html"]
