"""A picture of the arm: which browser draws it, what one that fails leaves behind, and a real one."""

from __future__ import annotations

import os
import subprocess
import tempfile
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from PIL import Image

from catalogue import load
from twistarm import InputError, TwistarmError, Viewer, plan_joint, save_png
from twistarm.cli.application import run
from twistarm.viewer.files import screenshot as headless
from viewer_page import stored, until

ARM = load("rr_planar")
SIZE = (320, 240)
COPY = 'for word in "$@"; do case "$word" in --screenshot=*) /bin/cp {} "${{word#--screenshot=}}";; esac; done\n'


@pytest.fixture(autouse=True)
def scratch(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder for temporary files: a screenshot leaves it empty."""
    folder = tmp_path / "scratch"
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    return folder


@pytest.fixture
def path(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The only folder on PATH, in a world without installed headless."""
    folder = tmp_path / "bin"
    folder.mkdir()
    monkeypatch.setenv("PATH", str(folder))
    monkeypatch.setattr(headless, "PLACES", ())
    return folder


def install(folder: Path, script: str, name: str = "chromium") -> Path:
    """A browser that is a shell script, and notes its arguments beside itself."""
    program = folder / name
    program.write_text(f'#!/bin/sh\nprintf "%s\\n" "$@" > "$0.arguments"\n{script}')
    program.chmod(0o755)
    return program


def arguments(program: Path) -> list[str]:
    return Path(f"{program}.arguments").read_text().splitlines()


def drawing(folder: Path, size: tuple[int, int] = SIZE) -> Path:
    """A picture that a browser might have drawn."""
    file = folder / "drawing.png"
    Image.effect_noise(size, 50.0).save(file)
    return file


def test_a_browser_is_found_on_path_or_in_the_usual_places(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (path / "chromium").write_text("not a program")
    with pytest.raises(TwistarmError, match="apt install chromium"):
        headless.find_browser()
    chrome = install(path, "", "google-chrome")
    assert headless.find_browser() == str(chrome)
    (path / "chromium").unlink()
    assert headless.find_browser() == str(chrome)
    away = path.parent / "Google Chrome.app"
    away.mkdir()
    monkeypatch.setattr(headless, "PLACES", ("/nowhere/chrome", str(install(away, "", "Google Chrome"))))
    monkeypatch.setenv("PATH", "")
    assert headless.find_browser() == str(away / "Google Chrome")


def test_a_snap_draws_below_the_home_folder(path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (path / "linked").symlink_to(install(path, "", "snap"))
    assert headless.is_snap(str(path / "linked"))
    assert not headless.is_snap(str(install(path, "exec /usr/lib/chromium/chromium\n", "google-chrome")))
    home = tmp_path / "home"
    home.mkdir()
    monkeypatch.setenv("HOME", str(home))
    program = install(path, "# /snap/bin/chromium\n" + COPY.format(drawing(tmp_path)))
    save_png(ARM, tmp_path / "arm.png", size=SIZE)
    assert arguments(program)[-1].startswith(f"file://{home}/twistarm-")
    assert list(home.iterdir()) == []


@pytest.mark.parametrize("lingers", [False, True])
def test_the_picture_is_what_the_browser_drew(
    path: Path, tmp_path: Path, scratch: Path, monkeypatch: pytest.MonkeyPatch, lingers: bool
) -> None:
    drawn, target = drawing(tmp_path), tmp_path / "arm.png"
    monkeypatch.setattr(headless, "TIMEOUT", 0.5 if lingers else 60.0)
    program = install(path, COPY.format(drawn) + "/bin/sleep 60\n" * lingers)
    assert save_png(ARM, target, size=SIZE) == target
    assert target.read_bytes() == drawn.read_bytes()
    given = arguments(program)
    assert "--window-size=320,240" in given
    assert any(word.startswith(f"--user-data-dir={scratch}/") for word in given), "a profile of its own"
    assert list(scratch.iterdir()) == []


def test_the_page_shows_the_posture(path: Path, tmp_path: Path) -> None:
    kept = tmp_path / "kept.html"
    keep = f'for word in "$@"; do :; done; word="${{word#file://}}"; /bin/cp "${{word%#pane}}" {kept}\n'
    install(path, keep + COPY.format(drawing(tmp_path)))
    with Viewer(ARM, [0.5, 0.6], open_browser=False) as viewer:
        viewer.show_screws(False)
        viewer.save_png(tmp_path / "arm.png", size=SIZE)
    shown = stored(kept.read_text("utf-8"))
    assert_allclose(shown["samples"]["theta"], [[0.5, 0.6]])
    assert shown["visible"]["screws"] is False
    motion = plan_joint(ARM, [[0.2, 0.1], [0.9, -0.5]], limits={"velocity": 1.0, "acceleration": 2.0})
    save_png(ARM, tmp_path / "arm.png", size=SIZE, trajectory=motion)
    shown = stored(kept.read_text("utf-8"))
    assert_allclose(shown["samples"]["theta"], [[0.2, 0.1]])
    # A path leaves out steps below 1e-4 of the arm (1 m).
    ends = np.array(shown["path"]["points"])[[0, -1]]
    assert_allclose(ends, ARM.fk(np.array([[0.2, 0.1], [0.9, -0.5]]))[:, :3, 3], atol=1e-4)


def ended(pid: int) -> bool:
    """Whether a process is dead, though nobody may have asked for its end yet."""
    done = subprocess.run(["/bin/ps", "-o", "stat=", "-p", str(pid)], capture_output=True, text=True, check=False)
    return not done.stdout.strip() or done.stdout.strip().startswith("Z")


def test_a_browser_that_hangs_is_ended_with_its_children(
    path: Path, tmp_path: Path, scratch: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(headless, "TIMEOUT", 0.5)
    install(path, f"/bin/sleep 60 & echo $! > {tmp_path}/child\n/bin/sleep 60\n")
    with pytest.raises(TwistarmError, match=r"0\.5 s"):
        save_png(ARM, tmp_path / "arm.png", size=SIZE)
    child = int((tmp_path / "child").read_text())
    until(lambda: ended(child))
    assert list(scratch.iterdir()) == []
    assert not (tmp_path / "arm.png").exists()


def test_a_picture_that_is_none_is_known(tmp_path: Path) -> None:
    whole = drawing(tmp_path).read_bytes()
    Image.new("RGB", SIZE, (238, 241, 245)).save(tmp_path / "blank.png")
    assert headless.fault(whole, SIZE) is None
    for data in (b"no picture", whole[: len(whole) // 2], drawing(tmp_path, (320, 200)).read_bytes()):
        assert headless.fault(data, SIZE)
    assert "WebGL" in str(headless.fault((tmp_path / "blank.png").read_bytes(), SIZE))


@pytest.mark.parametrize(
    ("script", "named"),
    [("echo 'no \033[1mscreen' >&2; exit 7\n", r"code 7 \(no \\x1b\[1mscreen"), (COPY.format('"$0"'), "PNG"),
     (None, "Exec format error")],
)  # fmt: skip
def test_a_browser_that_fails_changes_nothing(
    path: Path, tmp_path: Path, scratch: Path, script: str | None, named: str
) -> None:
    program = install(path, script or "")
    if script is None:
        program.write_bytes(b"\x7fELF")
    target = tmp_path / "arm.png"
    target.write_text("as it was")
    with pytest.raises(TwistarmError, match=named):
        save_png(ARM, target, size=SIZE)
    assert target.read_text() == "as it was"
    assert list(scratch.iterdir()) == []


def test_bad_sizes_paths_and_postures_are_refused_before_a_browser_starts(path: Path, tmp_path: Path) -> None:
    program = install(path, "")
    for size in ((1280,), (199, 720), (1280, 4097), (640.0, 480), "1280x720", None):
        with pytest.raises(InputError, match="size"):
            save_png(ARM, tmp_path / "arm.png", size=size)  # type: ignore[arg-type]
    for name in ("nowhere/arm.png", "bin", "arm.jpg"):
        with pytest.raises(InputError, match=name.partition("/")[0]):
            save_png(ARM, tmp_path / name)
    with pytest.raises(InputError, match="theta"):
        save_png(ARM, tmp_path / "arm.png", [0.1])
    assert not Path(f"{program}.arguments").exists()


def test_the_command(
    path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    install(path, COPY.format(drawing(tmp_path)))
    command = ["view", "rr_planar", "--theta", "10 20", "--force", "-o", "arm.png", "--size"]
    assert run([*command, "320x240", "-o", "arm.html"]) == 0
    assert capsys.readouterr().out.splitlines() == ["written: arm.png", "written: arm.html"]
    assert Image.open("arm.png").size == SIZE
    (path / "chromium").rename(path / "elsewhere")
    wrong = [*command, "320"], [*command, "10x9999"], ["view", "rr_planar", "-o", "new.html", "--size", "320x240"]
    for arguments, named in zip((*wrong, [*command, "320x240"]), ("--size", "size", "--size", "browser"), strict=True):
        assert run(arguments) == 2
        (line,) = capsys.readouterr().err.splitlines()
        assert named in line


@pytest.mark.browser
@pytest.mark.parametrize("size", [pytest.param((1280, 720), marks=pytest.mark.slow), (320, 640)])
def test_a_real_browser_draws_the_whole_arm(tmp_path: Path, scratch: Path, size: tuple[int, int]) -> None:
    """Screws are drawn pink, and in no other place but the legend: they show where the arm is."""
    try:
        headless.find_browser()
    except TwistarmError as error:
        if os.environ.get("TWISTARM_REQUIRE_ALL") == "1":
            pytest.fail(f"{error}, and TWISTARM_REQUIRE_ALL=1")
        pytest.skip(str(error))
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
    assert pixels[60:200, : size[0] // 12].min() > 150, "sky, where the panel of the page has its names"
    assert pixels[:60, -size[0] // 6 :].min() > 150, "sky, where the page has its switches"
    assert list(scratch.iterdir()) == []
