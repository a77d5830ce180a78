"""A view that is closed, closing or held up: its methods answer or say why not, and nothing keeps the program."""

from __future__ import annotations

import threading
import time
from dataclasses import replace
from typing import Any

import pytest
from numpy.testing import assert_array_equal

from twistarm import Arm
from twistarm.support.errors import InputError, TwistarmError
from twistarm.viewer import Viewer
from twistarm.viewer.server import server
from twistarm.viewer.server.handlers import DOWNLOADS
from viewer_page import THETA, WAIT, get, swing


def test_a_closed_view_shows_nothing_more_and_still_answers(arm: Arm, viewer: Viewer) -> None:
    viewer.close()
    moving = (
        lambda: viewer.show(THETA),
        lambda: viewer.play(swing(arm)),
        lambda: viewer.show_path(None),
        lambda: viewer.show_screws(False),
        lambda: viewer.show_frames(False),
        lambda: viewer.load(arm),
    )
    for call in moving:
        with pytest.raises(InputError, match="the viewer was closed"):
            call()
    viewer.show_servo(None)  # a loop that drives an arm goes on
    assert_array_equal(viewer.theta, THETA)
    assert "srcdoc" in viewer.inline(static=True).html


def test_a_loop_that_is_held_up_is_told_in_words(viewer: Viewer, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(server, "STOP_TIME", 0.2)
    free = threading.Event()
    viewer._server.post("hold", lambda stage: free.wait(WAIT))
    try:
        with pytest.raises(TwistarmError, match=r"^the viewer did not answer within 0\.2 s; it is busy: ask again$"):
            _ = viewer.theta
    finally:
        free.set()


# files that a page fetches ----------------------------------------------------------------------------


class Writing:
    """A download that waits for leave."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.begun, self.leave = threading.Semaphore(0), threading.Event()
        slow = replace(DOWNLOADS["motion.csv"], prepare=lambda stage, scene: self.write)
        monkeypatch.setitem(DOWNLOADS, "motion.csv", slow)  # type: ignore[arg-type]

    def write(self) -> str:
        self.begun.release()
        self.leave.wait(WAIT)
        return "written"


def fetch(viewer: Viewer, answers: list[Any]) -> threading.Thread:
    def run() -> None:
        try:
            answers.append(get(viewer.url + "motion.csv")[:2])
        except OSError as error:
            answers.append(error)

    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    return thread


def test_a_view_closes_at_once_while_a_file_is_written(arm: Arm, monkeypatch: pytest.MonkeyPatch) -> None:
    writing, answers = Writing(monkeypatch), list[Any]()
    before = set(threading.enumerate())
    viewer = Viewer(arm, open_browser=False)
    fetching = fetch(viewer, answers)
    assert writing.begun.acquire(timeout=WAIT)
    begin = time.monotonic()
    viewer.close()
    assert time.monotonic() - begin < 2.0
    assert [thread for thread in set(threading.enumerate()) - before if not thread.daemon] == []
    fetching.join(WAIT)
    assert isinstance(answers[0], OSError)
    writing.leave.set()


def test_what_a_file_fails_by_is_told(viewer: Viewer, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail() -> str:
        raise InputError("nothing to write")

    failing = replace(DOWNLOADS["motion.csv"], prepare=lambda stage, scene: fail)
    monkeypatch.setitem(DOWNLOADS, "motion.csv", failing)  # type: ignore[arg-type]
    assert get(viewer.url + "motion.csv")[:2] == (404, "nothing to write\n")


# a drive that begins ----------------------------------------------------------------------------------
