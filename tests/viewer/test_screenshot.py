"""A picture of the arm: what a browser that fails leaves behind, and a real one."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from PIL import Image

from catalogue import load
from needed import absent
from twistarm import InputError, TwistarmError, Viewer, plan_joint, save_png
from twistarm.cli.application import run
from twistarm.viewer import screenshot
from viewer_page import stored

ARM = load("rr_planar")
SIZE = (320, 240)


@pytest.fixture(autouse=True)
def scratch(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder for temporary files: a screenshot leaves it empty."""
    folder = tmp_path / "scratch"
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    return folder


@pytest.fixture
def browser(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The only browser on PATH: a script, which draws `drawing.png` beside it and keeps the page."""
    folder = tmp_path / "bin"
    folder.mkdir()
    Image.effect_noise(SIZE, 50.0).save(folder / "drawing.png")
    program = folder / "chromium"
    program.write_text(
        f'#!/bin/sh\nfor word in "$@"; do case "$word" in\n'
        f'--screenshot=*) /bin/cp {folder}/drawing.png "${{word#--screenshot=}}";;\n'
        f'file://*) word="${{word#file://}}"; /bin/cp "${{word%#pane}}" {folder}/page.html;;\nesac; done\n'
    )
    program.chmod(0o755)
    monkeypatch.setenv("PATH", str(folder))
    monkeypatch.setattr(screenshot, "BROWSERS", ("google-chrome", "chromium"))
    return program


def test_the_picture_is_what_the_browser_drew_of_the_posture(browser: Path, tmp_path: Path, scratch: Path) -> None:
    target = tmp_path / "arm.png"
    with Viewer(ARM, [0.5, 0.6], open_browser=False) as viewer:
        viewer.show_screws(False)
        assert viewer.save_png(target, size=SIZE) == target
    assert target.read_bytes() == browser.with_name("drawing.png").read_bytes()
    shown = stored(browser.with_name("page.html").read_text("utf-8"))
    assert_allclose(shown["frame"]["theta"], [0.5, 0.6])
    assert shown["visible"]["screws"][0] is False
    motion = plan_joint(ARM, [[0.2, 0.1], [0.9, -0.5]], limits={"velocity": 1.0, "acceleration": 2.0})
    save_png(ARM, target, size=SIZE, trajectory=motion)
    shown = stored(browser.with_name("page.html").read_text("utf-8"))
    assert_allclose(shown["frame"]["theta"], [0.2, 0.1])
    # A path leaves out steps below 1e-4 of the arm (1 m).
    ends = np.array(shown["path"]["points"])[[0, -1]]
    assert_allclose(ends, ARM.fk(np.array([[0.2, 0.1], [0.9, -0.5]]))[:, :3, 3], atol=1e-4)
    assert list(scratch.iterdir()) == []


def test_a_snap_draws_below_the_home_folder(browser: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    home = tmp_path / "home"
    home.mkdir()
    monkeypatch.setenv("HOME", str(home))
    folder = browser.with_name("folder")
    browser.write_text(browser.read_text().replace("#!/bin/sh", f"#!/bin/sh\n# /snap/bin/\necho {home}/* > {folder}"))
    save_png(ARM, tmp_path / "arm.png", size=SIZE)
    assert folder.read_text().startswith(f"{home}/twistarm-")
    assert list(home.iterdir()) == []


@pytest.mark.parametrize(
    ("program", "named"),
    [(b"#!/bin/sh\nexit 7\n", "code 7"), (b"#!/bin/sh\n/bin/sleep 60\n", r"0\.5 s"), (b"\x7fELF", "chromium")],
)
def test_a_browser_that_fails_changes_nothing(
    browser: Path, tmp_path: Path, scratch: Path, monkeypatch: pytest.MonkeyPatch, program: bytes, named: str
) -> None:
    monkeypatch.setattr(screenshot, "TIMEOUT", 0.5)
    browser.write_bytes(program)
    target = tmp_path / "arm.png"
    target.write_text("as it was")
    with pytest.raises(TwistarmError, match=named):
        save_png(ARM, target, size=SIZE)
    assert target.read_text() == "as it was"
    assert list(scratch.iterdir()) == []


def test_a_picture_that_is_none_is_known(browser: Path, tmp_path: Path) -> None:
    drawn, target = browser.with_name("drawing.png"), tmp_path / "arm.png"
    for image in (Image.new("RGB", SIZE, (238, 241, 245)), Image.effect_noise((320, 200), 50.0)):
        image.save(drawn)
        with pytest.raises(TwistarmError, match="chromium"):
            save_png(ARM, target, size=SIZE)
    drawn.write_bytes(drawn.read_bytes()[:200])
    with pytest.raises(TwistarmError, match="PNG"):
        save_png(ARM, target, size=SIZE)
    assert not target.exists()


def test_bad_sizes_paths_and_postures_are_refused_before_a_browser_starts(browser: Path, tmp_path: Path) -> None:
    for size in ((1280,), (199, 720), (1280, 4097), (640.0, 480), "1280x720", None):
        with pytest.raises(InputError, match="size"):
            save_png(ARM, tmp_path / "arm.png", size=size)  # type: ignore[arg-type]
    for name in ("nowhere/arm.png", "bin", "arm.jpg"):
        with pytest.raises(InputError, match=name.partition("/")[0]):
            save_png(ARM, tmp_path / name)
    with pytest.raises(InputError, match="theta"):
        save_png(ARM, tmp_path / "arm.png", [0.1])
    assert not browser.with_name("page.html").exists()


def test_the_command(
    browser: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    command = ["view", "rr_planar", "--theta", "10 20", "--force", "-o", "arm.png", "--size"]
    assert run([*command, "320x240", "-o", "arm.html"]) == 0
    assert Image.open("arm.png").size == SIZE
    browser.unlink()
    capsys.readouterr()
    wrong = [*command, "320"], [*command, "10x9999"], ["view", "rr_planar", "-o", "new.html", "--size", "320x240"]
    for arguments, named in zip((*wrong, [*command, "320x240"]), ("--size", "size", "--size", "Chromium"), strict=True):
        assert run(arguments) == 2
        (line,) = capsys.readouterr().err.splitlines()
        assert named in line


@pytest.mark.browser
@pytest.mark.parametrize("size", [pytest.param((1280, 720), marks=pytest.mark.slow), (320, 640)])
def test_a_real_browser_draws_the_whole_arm(tmp_path: Path, scratch: Path, size: tuple[int, int]) -> None:
    """Screws are drawn pink, and in no other place but the legend: they show where the arm is."""
    try:
        screenshot.find_browser()
    except TwistarmError as error:
        absent(str(error))
    picture = Image.open(save_png(load("rover_arm"), tmp_path / "arm.png", size=size))
    assert picture.size == size
    pixels = np.asarray(picture.convert("RGB")).astype(int)
    assert pixels.std() > 10
    red, green, blue = np.moveaxis(pixels, -1, 0)
    rows, columns = np.nonzero((red > 180) & (green < 90) & (blue > 100))
    legend = rows < 60
    assert legend.any()
    assert (~legend).sum() > size[0] / 10
    inside = columns[~legend] / size[0]
    assert 0.05 < inside.min() < inside.max() < 0.95
    assert list(scratch.iterdir()) == []
