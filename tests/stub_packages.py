"""Packages as a ROS shell or pip would put them on sys.path."""

from __future__ import annotations

from pathlib import Path


def package(folder: Path, name: str, text: str, **modules: str) -> Path:
    """A package with the given __init__.py and submodules."""
    (folder / name).mkdir(parents=True)
    (folder / name / "__init__.py").write_text(text)
    for module, content in modules.items():
        (folder / name / f"{module}.py").write_text(content)
    return folder
