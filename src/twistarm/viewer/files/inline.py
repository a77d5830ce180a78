"""The view in a notebook: a frame with the live page or a saved one."""

from __future__ import annotations

from dataclasses import dataclass
from html import escape

from ...support.checks import as_positive

HEIGHT = 480
"""Height of a frame [pixels]. It is as wide as the notebook's output."""

STYLE = "width:100%;border:1px solid #8884;border-radius:8px;color-scheme:normal"


@dataclass(frozen=True)
class Inline:
    """HTML that a notebook shows on a cell's last line or by IPython's `display`."""

    html: str

    def _repr_html_(self) -> str:
        return self.html

    @classmethod
    def live(cls, url: str, name: str, height: float = HEIGHT) -> Inline:
        """The page at `url`, which its process serves to notebooks of this machine."""
        return cls(_frame(name, height, f'src="{escape(url)}" allow="clipboard-write; gamepad; fullscreen"'))

    @classmethod
    def page(cls, html: str, name: str, height: float = HEIGHT) -> Inline:
        """A saved page in the notebook. It reaches nothing outside its frame."""
        sandbox = 'sandbox="allow-scripts allow-downloads" allow="clipboard-write; fullscreen"'
        return cls(_frame(name, height, f'{sandbox} srcdoc="{escape(html)}"'))


def _frame(name: str, height: float, content: str) -> str:
    pixels = round(as_positive(height, "height"))
    return f'<iframe title="{escape(name)} · twistarm" height="{pixels}" style="{STYLE}" {content}></iframe>'
