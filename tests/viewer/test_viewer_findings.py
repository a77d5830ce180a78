"""The doctor's findings on the page: what is told, which node each points at, and a doctor that is slow or fails."""

from __future__ import annotations

import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from twistarm import Arm, arm_from_screws, diagnose, joints, load_arm
from twistarm.checking.doctor import Diagnosis
from twistarm.description.findings import Finding, Place, finding
from twistarm.viewer import Viewer, save_html
from twistarm.viewer.messages import page_words
from twistarm.viewer.parts import arm_data as module
from twistarm.viewer.parts.arm_data import PENDING, doctor_findings, loading_findings, node_of
from twistarm.viewer.server import server as server_module
from viewer_page import Page, stored, visit

SCRIPT = "</script><script>hacked = 1</script>"
ESCAPED = SCRIPT.replace("<", "&lt;").replace(">", "&gt;")

URDF = f"""<robot name="patient">
  <link name="base_link"/>
  <link name="upper/{ESCAPED}"><inertial><mass value="90000"/>
    <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="floor"/><link name="tool0"/><link name="left"/>
  <joint name="{ESCAPED}" type="revolute"><parent link="base_link"/><child link="upper/{ESCAPED}"/>
    <axis xyz="0 0 2"/><limit lower="-1" upper="1" velocity="1" effort="1"/></joint>
  <joint name="table" type="planar"><parent link="upper/{ESCAPED}"/><child link="floor"/><origin xyz="0.3 0 0"/>
    <axis xyz="0 0 1"/></joint>
  <joint name="hand" type="fixed"><parent link="floor"/><child link="tool0"/></joint>
  <joint name="finger" type="prismatic"><parent link="tool0"/><child link="left"/><axis xyz="0 1 0"/>
    <limit lower="0" upper="0.04" velocity="0.1" effort="1"/></joint>
</robot>"""

UPPER = "/arm/link:upper%2F%3C%2Fscript%3E%3Cscript%3Ehacked%20%3D%201%3C%2Fscript%3E"


@pytest.fixture(scope="module")
def arm(tmp_path_factory: pytest.TempPathFactory) -> Arm:
    path = tmp_path_factory.mktemp("arm") / "patient.urdf"
    path.write_text(URDF)
    return load_arm(path, tip="tool0")


@pytest.fixture
def viewer(arm: Arm) -> Iterator[Viewer]:
    with Viewer(arm, open_browser=False) as served:
        yield served


@pytest.fixture(autouse=True)
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    """The doctor comes at once."""
    monkeypatch.setattr(server_module, "CALM_TIME", 0.02)


@pytest.fixture
def visits(monkeypatch: pytest.MonkeyPatch) -> list[Arm]:
    """The arms that the doctor has begun to look at."""
    seen: list[Arm] = []
    monkeypatch.setattr(module, "examine_arm", lambda arm: (seen.append(arm), Diagnosis(()))[1])
    return seen


def note(code: str, place: Place) -> Finding:
    return finding(code, place, "something", "a remedy")


def hear(viewer: Viewer, heard: Callable[[dict[str, Any]], bool]) -> Page:
    """A page that stays until the findings are as `heard` wants them."""
    with Page(viewer) as page:
        page.until(lambda: "findings" in page.latest and heard(page.latest["findings"]))
        return page


@pytest.mark.parametrize(
    ("element", "name", "node"),
    [
        ("link", "tool0", "/arm/link:tool0"),
        ("link", f"upper/{SCRIPT}", UPPER),
        ("joint", SCRIPT, "/screws/screw:0"),
        ("joint", "table", "/screws/screw:1"),  # the first of the three that a planar joint becomes
        ("joint", "hand", "/arm/link:tool0"),  # it does not move: what it carries
        ("joint", "finger", "/arm/link:left"),  # beside the chain
        ("joint", "nobody", None),
        ("link", "../../Lights", None),
        ("link", "hand", None),
        ("joint", "tool0", None),
        ("macro", "hand", None),
        ("robot", "patient", None),
        ("", "", None),
    ],
)
def test_the_node_that_a_finding_points_at(arm: Arm, element: str, name: str, node: str | None) -> None:
    assert node_of(arm, Place("patient.urdf", 1, element, name)) == node


def test_every_node_that_is_pointed_at_is_placed_in_the_scene(arm: Arm, viewer: Viewer) -> None:
    nodes = {told["node"] for told in doctor_findings(arm)["findings"]} - {None}
    assert {"/screws/screw:0", UPPER, "/arm/link:left"} <= nodes
    assert nodes <= set(visit(viewer).latest["hello"]["kinematics"]["nodes"])


def test_the_findings_are_those_of_diagnose_gravest_first(arm: Arm) -> None:
    found, message = diagnose(arm), doctor_findings(arm)
    assert len(found) > len(arm.findings) > 0
    told = [(one["severity"], one["code"], one["place"], one["what"], one["remedy"]) for one in message["findings"]]
    assert told == [(one.severity, one.code, str(one.place), *map(page_words, (one.what, one.remedy))) for one in found]
    assert message["counts"] == Counter(one.severity for one in found)
    assert message["note"] == ""


def test_an_arm_without_a_description_has_its_notes_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "examine_arm", lambda arm: pytest.fail("there is nothing to look at"))
    bare = arm_from_screws(joints.revolute([0, 0, 1], [0, 0, 0]), np.eye(4), joints=["turn"])
    assert (
        doctor_findings(bare)
        == loading_findings(bare)
        == {"type": "findings", "findings": [], "counts": {}, "note": ""}
    )
    assert node_of(bare, Place("bare", None, "joint", "turn")) == "/screws/screw:0"
    assert node_of(bare, Place("bare", None, "link", "turn")) is None
    with Viewer(bare, open_browser=False) as viewer:
        assert visit(viewer).latest["findings"] == loading_findings(bare)


def test_the_page_lives_while_the_doctor_is_slow(arm: Arm, viewer: Viewer, monkeypatch: pytest.MonkeyPatch) -> None:
    done = threading.Event()
    late = Diagnosis((note("number-malformed", Place("late")),))
    monkeypatch.setattr(module, "examine_arm", lambda arm: done.wait(10) and late)
    viewer.show(arm.random_theta(np.random.default_rng(0)))
    with Page(viewer) as page:
        assert page.latest["findings"] == loading_findings(arm)
        page.ask(type="pose", name="zero", ease=False)
        page.until(lambda: not any(page.latest["frame"]["theta"]))
        assert page.latest["findings"]["note"] == PENDING
        done.set()
        page.until(lambda: page.latest["findings"]["note"] == "")
        assert page.latest["findings"]["findings"][0]["place"] == "late"


def test_a_doctor_who_fails_is_told_and_the_page_lives(
    arm: Arm, viewer: Viewer, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(arm: Arm) -> None:
        raise RuntimeError(f"{SCRIPT}\nat a loss")

    monkeypatch.setattr(module, "examine_arm", fail)
    page = hear(viewer, lambda message: message["note"] != PENDING)
    told = page.latest["findings"]
    assert told["note"].endswith(rf"failed: {SCRIPT}\nat a loss")
    assert told["findings"] == loading_findings(arm)["findings"]
    assert "error" not in page.latest
    viewer.show(arm.ready)


def test_while_a_servo_drives_the_doctor_waits(viewer: Viewer, visits: list[Arm]) -> None:
    _ = viewer.commands
    with Page(viewer) as page:
        time.sleep(0.1)  # five times the doctor's patience
        assert visits == []
        assert page.latest["findings"]["note"] == PENDING
        viewer.show_servo(None)
        page.until(lambda: page.latest["findings"]["note"] == "")
        assert len(visits) == 1


def test_the_stand_alone_page_holds_the_diagnosis_and_no_name_breaks_out(arm: Arm, tmp_path: Path) -> None:
    page = save_html(arm, tmp_path / "view.html").read_text()
    assert "<script>hacked" not in page
    data = stored(page)
    assert data["findings"] == doctor_findings(arm)
    assert any(told["name"] == SCRIPT for told in data["findings"]["findings"])
