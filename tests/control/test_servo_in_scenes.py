"""The servo in scenes: it keeps bodies apart, slides along, leaves freely, and names the pair that holds it."""

import numpy as np
import pytest
from benchmarks.servo import REVERSALS, servo_arm, turns
from scipy.spatial.transform import Rotation

from stream_stand_ins import FakeClock, Robot, Says
from twistarm import InputError, JogCommand, PoseCommand, Scene, TwistCommand, load_arm
from twistarm.control.servo import ServoReason, ServoSettings, ServoState, servo_step
from twistarm.control.stream import StreamOptions, run

DT, MARGIN, SHORT = 0.01, 0.01, 5e-4  # s, m, and m: what a distance at rest may miss the margin by

SLIDES = """<robot name="slides"><link name="base"/><link name="carriage"/>
  <link name="hand"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
  <joint name="x" type="prismatic"><parent link="base"/><child link="carriage"/><axis xyz="1 0 0"/>
    <limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
  <joint name="z" type="prismatic"><parent link="carriage"/><child link="hand"/><axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" effort="1" velocity="1"/></joint></robot>"""
"""A hand of radius 0.1 m: at x = 0.9 it touches a wall at x = 1."""

HALTED = [JogCommand([0.3, 0.0]), TwistCommand([0.2, *[0] * 5], "base", [k == 2 for k in range(6)])]
HALTED += [PoseCommand(np.eye(4) + 2.0 * np.eye(4, k=3))]  # behind the wall


@pytest.fixture
def slides(tmp_path):
    file = tmp_path / "slides.urdf"
    file.write_text(SLIDES)
    arm = load_arm(file, tip="hand", limits={"acceleration": 1.0})
    scene = Scene(arm, margin=MARGIN)
    scene.add_box("wall", (1.0, 4.0, 8.0), (1.5, 0.0, 0.0))
    return arm, scene


def twist(x, z=0.0):
    return TwistCommand([x, 0, z, 0, 0, 0], "base")


def driven(arm, state, command, steps, scene, **settings):
    """All states and the last output."""
    states, output = [state], None
    for _ in range(steps):
        state, output = servo_step(arm, state, command, DT, scene=scene, settings=ServoSettings(**settings))
        states.append(state)
    return states, output


def test_a_hand_stops_before_a_wall_slides_along_it_and_leaves(slides):
    arm, scene = slides
    states, output = driven(arm, ServoState.at(arm, [0.5, 0.0]), twist(0.2, 0.1), 500, scene)
    x, z = np.transpose([state.theta for state in states])
    speed = np.array([state.theta_dot[0] for state in states])
    assert 0.9 - MARGIN - SHORT <= x[-1] == x.max() <= 0.9 - MARGIN
    assert z[-1] - z[-101] == pytest.approx(0.1, rel=0.01)  # m in a second, nearly as commanded
    assert (speed**2 <= 2.0 * 1.0 * (0.9 - MARGIN - x)).all()  # it can stop at 1 m/s²
    assert (output.status, output.reason) == ("SLOWED_COLLISION", ServoReason.COLLISION)
    assert (*sorted(output.contact.links), output.contact.margin) == ("hand", "wall", MARGIN)
    assert output.contact.distance == pytest.approx(0.9 - x[-1], abs=1e-6)
    assert output.explain() == f"slowed near a collision: {output.contact}"
    states, output = driven(arm, states[-1], twist(-0.2), 100, scene)
    assert (output.status, output.contact, output.theta_dot[0]) == ("OK", None, pytest.approx(-0.2))


@pytest.mark.parametrize("command", HALTED, ids=["jog", "held", "pose"])
def test_every_command_halts_before_the_wall(slides, command):
    arm, scene = slides
    states, output = driven(arm, ServoState.at(arm, [0.5, 0.0]), command, 800, scene)
    assert 0.9 - MARGIN - 3 * SHORT <= states[-1].theta[0] <= 0.9 - MARGIN
    assert output.status == "HALTED_COLLISION"
    assert all(state.theta[1] == pytest.approx(0.0, abs=1e-9) for state in states)


def test_an_arm_that_is_to_stop_where_it_cannot_follow_halts_on_its_course(slides):
    arm, scene = slides
    states, output = driven(arm, ServoState.at(arm, [0.5, 0.0]), twist(0.2, 0.1), 800, scene, on_unreachable="stop")
    assert output.explain() == f"stopped on its course: halted before a collision: {output.contact}"
    assert all(x - 0.5 == pytest.approx(2.0 * z, abs=1e-4) for x, z in (state.theta for state in states))


@pytest.mark.parametrize("start", [0.9 - 0.4 * MARGIN, 0.9, 0.95], ids=["inside the margin", "touching", "overlapping"])
@pytest.mark.parametrize("way", [JogCommand, lambda rates: twist(*rates)])
def test_an_arm_that_is_too_near_comes_no_nearer_and_leaves_as_without_a_scene(slides, start, way):
    arm, scene = slides
    state = ServoState.at(arm, [start, 0.0])
    states, output = driven(arm, state, way([0.2, 0.0]), 50, scene)
    assert max(state.theta[0] for state in states) <= start + 1e-5
    assert output.contact.distance == pytest.approx(0.9 - states[-2].theta[0], abs=1e-5)
    with_scene, without = (driven(arm, state, way([-0.2, 0.1]), 50, given)[0][-1] for given in (scene, None))
    assert with_scene.theta == pytest.approx(without.theta, abs=1e-9)


def test_a_command_that_ends_at_full_speed_stops_before_the_margin(slides):
    arm, scene = slides
    for moving in driven(arm, ServoState.at(arm, [0.4, 0.0]), JogCommand([1.0, 0.0]), 150, scene)[0][::5]:
        end = driven(arm, moving, None, 100, scene)[0][-1]
        assert end.theta[0] <= 0.9 - MARGIN


def toward_an_obstacle(arm, scene, rng, plane):
    """A free configuration, and a twist toward an obstacle before the tool."""
    while True:
        if "thing" in scene.obstacles:
            scene.remove("thing")
        theta = arm.random_theta(rng)
        place = np.eye(4)
        place[:3, :3] = Rotation.random(random_state=rng).as_matrix()
        z = place[:3, 2]
        place[:3, 3] = arm.fk(theta)[:3, 3] - rng.uniform(0.05, 0.2) * z
        behind = place - 0.1 * np.outer(place[:, 2], [0, 0, 0, 1])
        scene.add_plane("thing", place) if plane else scene.add_box("thing", (0.3, 0.2, 0.2), behind)
        if scene.distance(theta).metres > MARGIN + 0.003:
            return theta, TwistCommand([*(-0.2 * z + 0.05 * rng.normal(size=3)), 0, 0, 0], "base")


@pytest.mark.parametrize("name", ["ur5", "rover_arm", "panda"])
def test_held_twists_toward_obstacles_keep_the_margin_and_do_not_shake(name):
    arm, rng, held = servo_arm(name), np.random.default_rng(0), 0
    scene = Scene(arm, margin=MARGIN)
    for plane in (True, False, False):
        theta, command = toward_an_obstacle(arm, scene, rng, plane)
        states, _ = driven(arm, ServoState.at(arm, theta), command, 800, scene)
        turning = TwistCommand([*command.twist[:3], *rng.normal(size=3)], "base")
        spun, _ = driven(arm, states[0], turning, 200, scene)
        distances = [scene.distance(state.theta).metres for state in states[::4] + spun]
        assert min(distances) >= MARGIN - SHORT, (plane, theta, command)
        assert turns(np.array([state.theta_dot for state in states]))[0] < REVERSALS, (plane, theta, command)
        held += min(distances) < MARGIN + SHORT
    assert held


def test_flat_bodies_that_meet_at_two_corners_do_not_shake():
    arm = load_arm("stanford", limits={"velocity": 1.5, "acceleration": 3.0})
    scene, place = Scene(arm, margin=MARGIN), np.eye(4)
    place[:3, :3], place[:3, 3] = Rotation.from_rotvec([0.474, -1.639, -1.933]).as_matrix(), (0.198, -0.212, 1.287)
    scene.add_box("box", (0.3, 0.2, 0.2), place)
    start = ServoState.at(arm, [-1.863, -1.493, 0.288, -1.38, -0.093, 3.021])
    states, _ = driven(arm, start, TwistCommand([0.11, -0.177, -0.028, 0, 0, 0], "base"), 1200, scene)
    assert scene.distance(states[-1].theta).metres == pytest.approx(MARGIN, abs=SHORT)
    assert turns(np.array([state.theta_dot for state in states]))[0] < REVERSALS


def test_bodies_that_are_far_change_nothing(slides):
    arm, scene = slides
    start, way = ServoState.at(arm, [0.0, 0.0]), twist(-0.1, 0.05)
    with_scene, without = (driven(arm, start, way, 50, given)[0][-1] for given in (scene, None))
    assert np.array_equal([with_scene.theta, with_scene.theta_dot], [without.theta, without.theta_dot])


def test_a_stream_keeps_the_margin_and_refuses_the_scene_of_another_arm(slides):
    arm, scene = slides
    robot, other = Robot([0.5, 0.0], clock := FakeClock()), load_arm("ur5")
    assert run(
        arm, Says(JogCommand([0.3, 0.0])), robot, robot, StreamOptions(scene=scene), duration=4.0, clock=clock
    ).ok
    assert 0.9 - MARGIN - 3 * SHORT <= robot.theta[0] <= 0.9 - MARGIN
    with pytest.raises(InputError, match="scene is one of slides"):
        servo_step(other, ServoState.at(other, other.ready), None, DT, scene=scene)
    with pytest.raises(InputError, match="scene"):
        run(arm, Says(None), robot, robot, StreamOptions(scene="scene.toml"), duration=0.1, clock=clock)
