"""The site: whole, self-contained, ours alone, made anew only where something has changed."""

from __future__ import annotations

import re
import shutil
from html.parser import HTMLParser
from pathlib import Path

import pytest

from small_course import LESSON, ROVER
from twistarm import InputError, TwistarmError
from twistarm.guide.building import building
from twistarm.guide.building.building import RECORD, SOLUTION, Built, build, pdf_of
from twistarm.guide.course import LESSONS, SECTIONS, lesson_named
from twistarm.guide.exercises import exercises_of


class Page(HTMLParser):
    """What a page refers to and names, and what it nests."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.refers: list[str] = []
        self.names: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        for key, value in attrs:
            if key in ("href", "src") and value:
                self.refers.append(value)
            if key == "id" and value:
                self.names.append(value)


def test_pages_refer_to_what_is_there_and_to_nowhere_else(built: Built) -> None:
    pages = {path.name: Page(path.read_text("utf-8")) for path in built.folder.glob("*.html")}
    assert set(pages) == {"index.html", "before.html", "errata.html", f"{LESSON}.html"}
    for name, page in pages.items():
        assert len(set(page.names)) == len(page.names), f"{name} has a name twice"
        for target in page.refers:
            file, _, anchor = target.partition("#")
            if target == "data:,":
                continue
            assert not re.match(r"\w+:|//", target), f"{name} asks elsewhere: {target}"
            assert not file or (built.folder / file).is_file(), f"{name}: {target}"
            if anchor:
                assert anchor in pages[file or name].names, f"{name}: {target}"


def test_a_lesson_ends_with_its_exercises_and_the_contents_say_how_they_are_graded(built: Built) -> None:
    page = (built.folder / f"{LESSON}.html").read_text("utf-8")
    for exercise in exercises_of(LESSON):
        assert f'<h3 id="exercise-{exercise.name}">' in page
    assert page.count("<summary>Show a solution</summary>") == len(exercises_of(LESSON))
    assert f"twistarm guide check guide_exercises/{LESSON}.py" in page
    sheet = re.sub(SOLUTION, "", page, flags=re.DOTALL)
    assert "Show a solution" not in sheet
    assert sheet.count('<h3 id="exercise-') == len(exercises_of(LESSON))
    index = (built.folder / "index.html").read_text("utf-8")
    assert all(f"twistarm guide {command}" in index for command in ("exercises", "check"))


def test_scenes_share_their_scripts_and_allow_no_others(built: Built) -> None:
    scenes = list((built.folder / "scenes").glob("scene_*.html"))
    text = scenes[0].read_text("utf-8")
    policy = re.search(r'Content-Security-Policy" content="([^"]+)"', text)[1]  # type: ignore[index]
    nonce = re.search(r"script-src 'nonce-(\w+)'", policy)[1]  # type: ignore[index]
    assert policy.startswith("default-src 'none'; script-src 'nonce-")
    scripts = re.findall(r"<script(?! type=\"application/json\")([^>]*)>", text)
    assert len(scripts) == 4
    for attributes in scripts:
        assert f'nonce="{nonce}"' in attributes
        assert (built.folder / "scenes" / re.search(r'src="([^"]+)"', attributes)[1]).is_file()  # type: ignore[index]
    assert len(text) < 200_000, "the bundle and the meshes lie beside the page"


def test_nothing_is_made_twice(built: Built) -> None:
    assert built.failed == ()
    assert build(built.folder, ROVER, [LESSON]).run == ()


@pytest.mark.slow
def test_what_is_lost_is_made_again_and_a_reader_s_files_stay(built: Built, tmp_path: Path) -> None:
    own = tmp_path / "course"
    shutil.copytree(built.folder, own)
    (own / "notes.txt").write_text("mine")
    stale = own / "scenes" / "scene_0123456789ab.html"
    for path in (stale, own / "scenes" / "notes.html"):
        path.write_text("mine")
    page = own / f"{LESSON}.html"
    text = page.read_text("utf-8")
    page.unlink()
    assert build(own, ROVER, [LESSON]).run == (LESSON,)
    assert page.read_text("utf-8") == text, "the same lesson on the same arm is the same page"
    assert not stale.exists(), "a scene of ours that no page needs"
    assert all(path.read_text() == "mine" for path in (own / "notes.txt", own / "scenes" / "notes.html"))


def test_a_folder_of_somebody_else_is_left_alone(tmp_path: Path) -> None:
    mine = tmp_path / "notes.txt"
    mine.write_text("mine")
    with pytest.raises(InputError, match="holds something that the guide did not write .*; give a new folder"):
        build(tmp_path, ROVER)
    with pytest.raises(InputError, match="is a file; -o takes a folder"):
        build(mine, ROVER)
    with pytest.raises(InputError, match="cannot write into .*notes.txt"):
        build(mine / "below", ROVER)
    assert [path.name for path in tmp_path.iterdir()] == ["notes.txt"]


@pytest.mark.slow
@pytest.mark.browser
def test_a_lesson_is_printed(tmp_path: Path) -> None:
    made = build(tmp_path / "site", {"source": "rr_planar"}, LESSONS[:1])
    assert len(pdf_of(made.folder, LESSONS[0])) > 20_000


@pytest.mark.parametrize("text", ["{", "[]"])
def test_a_broken_record_is_begun_anew(text: str, tmp_path: Path) -> None:
    (tmp_path / RECORD).write_text(text)
    assert build(tmp_path, ROVER, []).failed == ()
    assert (tmp_path / "index.html").is_file()


@pytest.mark.slow
def test_an_endless_lesson_and_one_that_dies_are_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    head = "# %% [markdown]\n# # A title\n\n# %%\n"
    (tmp_path / "endless.py").write_text(head + "import time\ntime.sleep(60)\n")
    (tmp_path / "dying.py").write_text(head + "import os, sys\nsys.stderr.write('last words\\n')\nos._exit(3)\n")
    monkeypatch.setattr(building, "lesson_file", lambda name: tmp_path / f"{name}.py")
    made = dict(building.run_lessons(["endless"], ROVER, tmp_path, timeout=4.0))
    assert made["endless"]["failed"].startswith("endless: was ended after 4 s")
    assert made["endless"]["failed"] in made["endless"]["body"]
    made = dict(building.run_lessons(["dying"], ROVER, tmp_path))
    assert made["dying"]["failed"] == "dying: ended with code 3: last words"


def test_the_course_names_every_lesson_once_and_every_section() -> None:
    assert len(set(LESSONS)) == len(LESSONS)
    assert {name for *_, name in SECTIONS} == set(LESSONS)
    assert lesson_named(f"examples/guide/{LESSONS[0]}.py") == LESSONS[0]
    with pytest.raises(TwistarmError, match="no lesson '3_1_forward' in the guide; closest: '3_1_forward_kinematics'"):
        lesson_named("3_1_forward")
