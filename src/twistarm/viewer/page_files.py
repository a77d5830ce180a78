"""The files of the page: our own, and Meshcat's bundle from its installed wheel."""

from __future__ import annotations

from importlib.resources import files

TYPES = {
    "html": "text/html; charset=utf-8",
    "css": "text/css; charset=utf-8",
    "js": "text/javascript; charset=utf-8",
    "json": "application/json",
}


def page_text(name: str) -> str:
    """One of our own files as text."""
    return files(__package__).joinpath("page").joinpath(name).read_text(encoding="utf-8")


def meshcat_bundle() -> str:
    """Meshcat's page code, three.js included, as its wheel carries it."""
    wheel = files("meshcat")
    return wheel.joinpath("viewer").joinpath("dist").joinpath("main.min.js").read_text(encoding="utf-8")


def page_files() -> dict[str, tuple[str, bytes]]:
    """Each file by its name under the token: (content type, content). '' is the page."""
    folder = files(__package__).joinpath("page")
    own = {item.name: item.read_bytes() for item in folder.iterdir() if item.name.rpartition(".")[2] in TYPES}
    served = {name: (TYPES[name.rpartition(".")[2]], content) for name, content in own.items()}
    served[""] = served["index.html"]
    served["meshcat.js"] = (TYPES["js"], meshcat_bundle().encode())
    return served
