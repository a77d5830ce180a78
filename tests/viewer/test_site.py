"""A folder of arms for a web server: its pages and links, and that it is written whole or not at all."""

from __future__ import annotations

import json
import os
import re
from pathlib import Path

import numpy as np
import pytest

from twistarm import InputError, load_arm, save_site
from twistarm.cli.application import run
from twistarm.viewer import screenshot
from twistarm.viewer.saved_page import of_arm
from urdf_text import two_joints

ODD = "<b> & ../ü $count 機"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Four descriptions, two with one name; no browser."""
    for file, name in (("a", ODD), ("b", "index"), ("c", "two"), ("d", "two")):
        named = re.sub(
            r'<robot name="[^"]*"', f'<robot name="{name.replace("&", "&amp;").replace("<", "&lt;")}"', two_joints()
        )
        (tmp_path / f"{file}.urdf").write_text(named)
    (tmp_path / "broken.urdf").write_text("<robot")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(screenshot, "BROWSERS", ())
    return tmp_path


def test_the_site_of_a_folder_of_arms(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["view", "a.urdf", "b.urdf", "c.urdf", "d.urdf", "--json", "-o", "site/"]) == 0
    out, err = capsys.readouterr()
    answer = json.loads(out)
    assert [arm["name"] for arm in answer["arms"]] == [ODD, "index", "two (c.urdf)", "two (d.urdf)"]
    assert sorted(os.listdir("site")) == sorted(answer["files"])
    assert len([line for line in err.splitlines() if " of 4: " in line]) == 4
    index = Path("site/index.html").read_text()
    assert re.findall(r'href="([^"]*\.html)"', index) == [arm["page"] for arm in answer["arms"]]
    assert len({arm["page"].lower() for arm in answer["arms"]} | {"index.html"}) == 5
    assert index.count("<svg") == 4, "drawn without a browser"
    for page in Path("site").glob("*.html"):
        links = re.findall(r'(?:src|href)="([^"]*)"', page.read_text())
        assert {link for link in links if not link.startswith("data:")} <= {*os.listdir("site"), "#"}, page.name
    arm = load_arm("c.urdf")
    reach = max(np.linalg.norm(arm.fk(theta)[:3, 3]) for theta in np.random.default_rng(1).uniform(-3, 3, (500, 2)))
    assert answer["arms"][2]["reach"] == pytest.approx(reach, rel=0.05)
    assert answer["arms"][2]["joints"] == {"revolute": 2}


def test_an_arm_that_does_not_load_is_named_and_nothing_is_written(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = sorted(os.listdir())
    assert run(["view", "a.urdf", "broken.urdf", "lost.urdf", "-o", "site/"]) == 2
    said = capsys.readouterr().err
    assert "broken.urdf" in said
    assert "lost.urdf" in said
    assert sorted(os.listdir()) == before


def test_what_stands_in_the_folder_is_kept_and_replaced_by_force_alone(folder: Path) -> None:
    site = Path("site")
    site.mkdir()
    assert run(["view", "c.urdf", "-o", "site/"]) == 0, "an empty folder is free"
    (site / "index.html").write_text("mine")
    (site / "CNAME").write_text("mine")
    assert run(["view", "c.urdf", "-o", "site"]) == 2
    assert (site / "index.html").read_text() == "mine"
    assert run(["view", "c.urdf", "-o", "site", "--force"]) == 0
    assert (site / "index.html").read_text() != "mine"
    assert (site / "CNAME").read_text() == "mine"
    assert run(["view", "a.urdf", "-o", "site", "--force"]) == 0
    assert not (site / "two.html").exists(), "the page of an arm that the site has no more"
    assert (site / "CNAME").read_text() == "mine"
    (site / "index.html").unlink()
    (site / "index.html").mkdir()
    before = {each: each.stat().st_mtime_ns for each in site.iterdir()}
    with pytest.raises(InputError, match=r"index\.html"):
        save_site([load_arm("c.urdf")], site)
    assert {each: each.stat().st_mtime_ns for each in site.iterdir()} == before


def test_a_site_by_python(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    arm = load_arm("c.urdf")
    monkeypatch.setattr("twistarm.viewer.site.png_of", lambda size, show: bytes(f"{show().arm.name} {size}", "utf-8"))
    index = save_site([arm, arm], "site")
    assert index.read_text().count("<img") == 2
    assert (index.parent / "two.png").read_bytes() == b"two (640, 400)"
    for wrong in ([], 5, [of_arm(arm)]):
        with pytest.raises(InputError):
            save_site(wrong, "other")  # type: ignore[arg-type]
    with pytest.raises(InputError, match="nowhere"):
        save_site([arm], "nowhere/site")
    assert not Path("other").exists()
