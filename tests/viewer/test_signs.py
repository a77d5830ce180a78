"""The signs of the page and of the course's site: a plain Debian has a font with each."""

from pathlib import Path

import pytest

import twistarm


def test_each_sign_is_in_the_usual_font() -> None:
    font_files = pytest.importorskip("fontTools.ttLib")
    data = Path(pytest.importorskip("matplotlib").get_data_path())
    known = font_files.TTFont(data / "fonts" / "ttf" / "DejaVuSans.ttf").getBestCmap()
    package = Path(twistarm.__file__).parent
    folders = package / "viewer", package / "guide"
    files = [path for folder in folders for path in folder.rglob("*") if path.suffix in (".js", ".css", ".html", ".py")]
    assert len(files) > 100
    lacking = {
        path.name: signs for path in files if (signs := {*path.read_text("utf-8")} - {chr(c) for c in known} - {"\n"})
    }
    assert lacking == {}
