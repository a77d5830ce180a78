"""Panels: verdicts against inverse kinematics at many points, motions against the screw, parking by known geometry."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import twistarm
from twistarm import Approach, Scene, best_parking, check_panel, compare_designs, load_arm, load_panel, solve_ik
from twistarm.design import Panel, PanelTask
from twistarm.support.checks import Array
from twistarm.support.errors import InputError, TwistarmError

EXAMPLE = Path(__file__).parents[2] / "examples" / "urc_panel.toml"
PRESS = '[[task]]\nname = "a"\nkind = "press"\nxyz = [0.0, 0.0, 0.0]\ntravel = 0.003\n'


def panel_of(tmp_path: Path, text: str) -> Panel:
    file = tmp_path / "panel.toml"
    file.write_text(text, "utf-8")
    return load_panel(file)


@pytest.fixture(scope="module")
def urc() -> Panel:
    return replace(load_panel(EXAMPLE), size=None)


def moved(task: PanelTask, panel: Panel, base: Array, s: Array) -> tuple[Array, Rotation]:
    """The thing's place (k, 3) at s (k,), seen from the base, and its rotation since the contact: by Rodrigues."""
    g = np.linalg.solve(base, panel.pose)
    v, w = task.twist[:3], task.twist[3:]
    turned = Rotation.from_rotvec(s[:, None] * w)
    if w.any():
        q = np.cross(w, v) / (w @ w)  # the point of the axis nearest to the origin
        p = q + turned.apply(task.place - q) + s[:, None] * (w @ v) / (w @ w) * w
    else:
        p = task.place + s[:, None] * v
    here = Rotation.from_matrix(g[:3, :3])
    return here.apply(p) + g[:3, 3], here * turned * here.inv()


def test_a_file_in_its_own_units_and_frame(tmp_path: Path) -> None:
    panel = panel_of(
        tmp_path,
        "degrees = true\norientation_tol = 1.0\n[panel]\nxyz = [2.0, 1.0, 0.8]\nnormal = [0, -3, 0]\n"
        '[parking]\nx = 0.5\nyaw = [0, 90]\n[[task]]\nname = "s"\nkind = "screw"\nxyz = [0.1, 0.2, 0.3]\nangle = 720\n'
        'lead = 0.0015\n[[task]]\nname = "d"\nkind = "pull"\nxyz = [0, 0, 0]\ntravel = 0.2\ndirection = [0, 2, 0]\n',
    )
    # The rover looks along world y: its right is x, up is z, and out of the panel is −y.
    assert np.allclose(panel.pose[:3], [[1, 0, 0, 2.0], [0, 0, -1, 1.0], [0, 1, 0, 0.8]])
    assert (panel.x, panel.y) == ((0.5, 0.5), (0.0, 0.0))
    assert np.allclose([panel.yaw[1], panel.tolerances["orientation_tol"]], [np.pi / 2, np.pi / 180])
    screw, drawer = panel.tasks
    p, turned = moved(screw, replace(panel, pose=np.eye(4)), np.eye(4), np.array([0.125, 1.0]))
    assert np.allclose(p[1], [0.1, 0.2, 0.3 - 2 * 0.0015]), "two turns into the panel"
    assert np.allclose(turned[0].as_rotvec(), [0.0, 0.0, -np.pi / 2]), "clockwise for who looks at it"
    assert np.allclose(drawer.twist, [0.0, -0.2, 0.0, 0.0, 0.0, 0.0])
    assert np.allclose(drawer.direction, [0.0, 1.0, 0.0])


@pytest.mark.parametrize(("name", "place"), [("rover_arm", (-0.95, 0.1, 0.0)), ("rover_arm_6dof", (-1.2, 0.1, 0.1))])
def test_verdicts_agree_with_inverse_kinematics_along_the_task(name: str, place: Any, urc: Panel) -> None:
    arm, base = load_arm(name), urc.base_at(*place)
    report = check_panel(arm, urc, base)
    verdicts = set()
    for result in report.results:
        task = result.task
        p, turned = moved(task, urc, base, np.linspace(0.0, 1.0, 21))
        first = np.linalg.solve(base, urc.pose)[:3, :3] @ task.direction
        directions = turned.apply(first) if task.hold == "pose" else np.tile(first, (21, 1))
        beyond = 0.0 if task.back else max(0.0, (p[-1] - p[0]) @ first)
        away = p[0 if task.back else -1] - (urc.clearance + beyond) * directions[0 if task.back else -1]
        asked = [Approach(p[0] - urc.clearance * first, first), *map(Approach, p, directions)]
        asked.append(Approach(away, directions[0 if task.back else -1]))
        met = all(solve_ik(arm, target, rng=3, restarts=200).converged for target in asked)
        if result.code == "done":
            assert met, task.name
        else:
            assert not met or "no farther" in result.why, (task.name, result.why)
        verdicts.add(result.code)
    assert len(verdicts) > 1, "some are done, others are not"
    assert len(report.done) >= 5


def test_the_tool_obeys_each_screw(rover: twistarm.Arm, urc: Panel) -> None:
    base = urc.base_at(-0.97, -0.09, 0.0)
    asked = ["knob", "latch", "switch", "tighten screw", "open drawer", "USB stick"]
    few = replace(
        urc, tasks=tuple(sorted((x for x in urc.tasks if x.name in asked), key=lambda x: asked.index(x.name)))
    )
    report = check_panel(rover, few, base)
    motion = report.motion(limits={"acceleration": 3.0}, kind="time_optimal")
    assert [label for _, label in motion.labels] == asked
    for end, name in motion.labels:
        task = next(other for other in urc.tasks if other.name == name)
        begin = motion.times[int(np.searchsorted(motion.times, end - 1e-9)) - 1]
        t = np.linspace(begin, end, 400)
        g = rover.fk(motion(t))
        # The share s that the tool has done, from the place nearest to its own.
        s = np.linspace(0.0, 1.0, 20001)
        way, _ = moved(task, urc, base, s)
        if np.ptp(way, axis=0).max() > 1e-4:
            off = np.array([np.linalg.norm(way - p, axis=1).min() for p in g[:, :3, 3]])
            assert off.max() < 1.5e-4, name
        (start, finish), (_, whole) = moved(task, urc, base, np.array([0.0, 1.0]))
        assert np.abs(g[[0, -1], :3, 3] - [start, finish]).max() < 1e-4, name
        steps = Rotation.from_matrix(g[1:, :3, :3] @ np.swapaxes(g[:-1, :3, :3], 1, 2)).as_rotvec()
        turned = steps.sum(axis=0)  # about one axis, so that whole turns count
        wanted = np.linalg.solve(base, urc.pose)[:3, :3] @ task.twist[3:] * (task.hold == "pose")
        free = g[0, :3, 2] if task.hold != "pose" else np.zeros(3)  # a pushing tool may roll
        assert np.abs((turned - wanted) - ((turned - wanted) @ free) * free).max() < 2e-3, name
        assert task.hold != "pose" or np.allclose(whole.as_matrix(), (g[-1] @ np.linalg.inv(g[0]))[:3, :3], atol=2e-3)


def test_what_is_measured_along_a_task(rover: twistarm.Arm, urc: Panel) -> None:
    only = replace(urc, tasks=urc.tasks[:1])
    (result,) = check_panel(rover, only, urc.base_at(-0.95, 0.0, 0.0)).results
    room = np.minimum(result.theta - rover.limits.lower, rover.limits.upper - result.theta)
    assert result.margin == room.min()
    assert result.joint == rover.joint_names[np.unravel_index(room.argmin(), room.shape)[1]]
    assert np.isclose(result.condition, rover.manipulability(result.theta).condition.max())
    assert result.clearance == np.inf
    boxed = replace(only, size=np.array([1.0, 1.0, 0.1]), gap=0.05)
    (with_box,) = check_panel(rover, boxed, urc.base_at(-0.95, 0.0, 0.0)).results
    # The tip goes 4 mm into the key, and the box begins 50 mm behind it.
    assert 0.0 < with_box.clearance <= 0.046 + 1e-3
    (inside,) = check_panel(rover, replace(boxed, gap=-0.02), urc.base_at(-0.95, 0.0, 0.0)).results
    assert inside.code == "in_collision"
    assert "panel" in inside.why


def test_why_a_task_fails(rover: twistarm.Arm, tmp_path: Path) -> None:
    panel = panel_of(
        tmp_path,
        "[panel]\nxyz = [0.95, 0.0, 0.8]\n"
        + PRESS
        + PRESS.replace('"a"', '"far"').replace("[0.0, 0.0, 0.0]", "[0.0, 2.0, 0.0]")
        + PRESS.replace('"a"', '"aside"').replace("[0.0, 0.0, 0.0]", "[0.45, 0.0, 0.0]")
        + PRESS.replace('"a"', '"across"')
        + "direction = [0.5, 0.0, -1.0]\n",
    )
    codes = [result.code for result in check_panel(rover, panel).results]
    assert codes == ["done", "out_of_reach", "done", "impossible_direction"]
    short = replace(rover, limits=rover.limits.with_({"lower": {"slide": -0.1}}, rover.joint_names))
    aside = check_panel(short, panel).results[2]
    assert aside.code == "blocked_by_limits"
    assert "slide" in aside.why
    scene = Scene(rover)
    scene.add_box("post", (0.02, 0.02, 0.4), (0.93, 0.0, 0.8))
    blocked, *_, across = check_panel(rover, panel, scene=scene).results
    assert (blocked.code, across.code) == ("in_collision", "impossible_direction")
    assert "post" in blocked.why
    assert list(scene.obstacles) == ["post"], "the caller's scene stays as it was"


def test_the_parking_pose_that_geometry_asks_for(rover: twistarm.Arm, tmp_path: Path) -> None:
    # Two keys 0.8 m apart, and a slide of ±0.5 m across the way to them: only from between them both are pressed.
    two = "".join(PRESS.replace('"a"', f'"{x}"').replace("[0.0,", f"[{x},") for x in (-0.4, 0.4))
    there = "[panel]\nxyz = [1.0, 0.3, 0.8]\n[parking]\nx = [-0.6, 0.4]\ny = [-0.4, 1.0]\nyaw = [-0.5, 0.5]\n"
    panel = panel_of(tmp_path, there + two)
    heard: list[float] = []
    report = best_parking(rover, panel, progress=heard.append)
    assert len(report.done) == 2
    middle = 0.3 - rover.fk(rover.ready)[1, 3]  # the tool is beside the slide
    assert abs(report.base[1, 3] - middle) < 0.01
    assert np.allclose(report.base[:3, :3], np.eye(3)), "this arm works straight ahead"
    assert report.margin > 0.08
    assert heard == sorted(heard)
    assert heard[-1] == 1.0
    assert len(check_panel(rover, panel, panel.base_at(0.0, 0.0, 0.0)).done) == 1
    again = check_panel(rover, panel, report.base)
    assert [result.code for result in again.results] == [result.code for result in report.results]
    nowhere = best_parking(rover, replace(panel, y=(3.0, 3.0)))
    assert not nowhere.done
    assert {result.code for result in nowhere.results} == {"blocked_by_limits"}
    with pytest.raises(InputError, match="no task of the panel is done"):
        nowhere.motion()


TURN = PRESS.replace("press", "turn").replace("travel = 0.003", "angle = {}")
BAD = {
    "no TOML": ("[[task", "TOML"),
    "no task": ("degrees = true", "'task'"),
    "an unknown entry": (PRESS + "presure = 3\n", "task 1.*'presure'"),
    "an equal name": (PRESS + PRESS, "task 2: name"),
    "no travel": (PRESS.replace("travel", "# travel"), "'travel'"),
    "millimetres": (PRESS.replace("0.003", "3"), "travel is 3 m"),
    "no direction": (PRESS + "direction = [0, 0, 0]\n", "direction"),
    "degrees": (TURN.format(90), "degrees = true"),
    "angle 0": (TURN.format(0), "angle"),
    "an idle lever": (TURN.format("1\naxis = [0, 1, 0]").replace("turn", "flip"), "point"),
    "an empty range": ("[parking]\nx = [1, 0]\n" + PRESS, "parking.x"),
    "a flat panel": ("[panel]\nnormal = [0, 0, 1]\n" + PRESS, "normal and up"),
    "a thin panel": ("[panel]\nsize = [1, 1, 0]\n" + PRESS, "panel.size"),
}


@pytest.mark.parametrize("which", BAD)
def test_a_bad_file_is_refused_in_one_line(which: str, tmp_path: Path) -> None:
    text, culprit = BAD[which]
    with pytest.raises(TwistarmError, match=culprit) as caught:
        panel_of(tmp_path, text)
    assert "panel.toml" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_wide_ranges_are_searched_on_a_bounded_grid(rover: twistarm.Arm, tmp_path: Path) -> None:
    wide = "[parking]\nx = [-10, 10]\ny = [-10, 10]\nyaw = [-3.2, 3.2]\n"
    report = best_parking(rover, panel_of(tmp_path, wide + PRESS))
    assert 1000 < len(report.places) < 20_000
    assert len(report.done) == 1
    thin = best_parking(rover, panel_of(tmp_path, wide.replace("y = [-10, 10]", "y = 0") + PRESS))
    assert 500 < len(thin.places) < 20_000
    assert len(thin.done) == 1


def test_designs_by_their_share_of_a_panel(rover: twistarm.Arm, tmp_path: Path) -> None:
    two = "".join(PRESS.replace('"a"', f'"{x}"').replace("[0.0,", f"[{x},") for x in (-0.4, 0.0))
    panel = panel_of(tmp_path, "[panel]\nxyz = [0.95, 0.0, 0.8]\n" + two)
    bounds = {"lower": {"slide": -0.1}, "upper": {"slide": 0.1}}
    short = replace(rover, name="short", limits=rover.limits.with_(bounds, rover.joint_names))
    ours, other = compare_designs([rover, short], panel=panel)
    assert (ours.panel, other.panel) == (1.0, 0.5)
