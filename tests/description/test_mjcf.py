"""MJCF against MuJoCo's own kinematics, compiler and masses; and files that are no use."""

from __future__ import annotations

import contextlib
import os
import pickle
import random
import signal
import sys
from pathlib import Path

import mujoco
import numpy as np
import pytest

from random_mjcf import Random
from twistarm import Arm, crosscheck, load_arm
from twistarm.description.findings import Finding
from twistarm.description.geometry import bodies
from twistarm.support.errors import DescriptionError, MissingExtraError, TwistarmError
from twistarm.support.interrupts import ending_at_once

DATA = Path(__file__).parents[1] / "data" / "mjcf"
FILES = sorted(DATA.glob("*.xml"))
RATES_ALIKE = [path for path in FILES if path.stem not in ("couplings", "overrides")]
TOL = 1e-12
UNNAMED = "body3_joint"  # What a joint of the body without a name is called in several_joints.xml.


def file(name: str) -> str:
    return str(DATA / f"{name}.xml")


def moved(model: mujoco.MjModel, data: mujoco.MjData, arm: Arm, theta: np.ndarray) -> dict[str, np.ndarray]:
    """The pose of each named body and site. Other joints stand at 0, balls at rest, followers as `equality` says."""
    values = dict(zip(arm.joint_names, theta, strict=True))
    data.qpos[:] = model.qpos0
    for i in range(model.njnt):
        at, name = model.jnt_qposadr[i], model.joint(i).name
        if mujoco.mjtJoint(model.jnt_type[i]) not in (mujoco.mjtJoint.mjJNT_BALL, mujoco.mjtJoint.mjJNT_FREE):
            data.qpos[at] = values.get(name or UNNAMED, 0.0)
    for i in [*range(model.neq)] * model.neq:  # a follower may lead another
        if model.eq_active0[i] and not model.eq_data[i, 2:5].any():
            one, other = model.jnt_qposadr[model.eq_obj1id[i]], model.eq_obj2id[i]
            a0, a1 = model.eq_data[i, :2]
            way = 0.0 if other < 0 else data.qpos[model.jnt_qposadr[other]] - model.qpos0[model.jnt_qposadr[other]]
            data.qpos[one] = model.qpos0[one] + a0 + a1 * way
    mujoco.mj_kinematics(model, data)
    poses = {}
    for name, p, R in [
        *((model.body(i).name, data.xpos[i], data.xmat[i]) for i in range(model.nbody)),
        *((model.site(i).name, data.site_xpos[i], data.site_xmat[i]) for i in range(model.nsite)),
    ]:
        poses[name] = np.vstack([np.column_stack([R.reshape(3, 3), p]), [0.0, 0.0, 0.0, 1.0]])
    return poses


def require_as_mujoco(arm: Arm, path: Path, samples: int) -> int:
    """Compare poses, limits, efforts and masses with MuJoCo's. Return how many poses of bodies and sites there were."""
    model = mujoco.MjModel.from_xml_path(str(path))
    data, compared = mujoco.MjData(model), 0
    for theta in arm.random_theta(0, samples):
        theirs, ours = moved(model, data, arm, theta), arm.poses(theta)
        for name in theirs.keys() & ours.keys():
            np.testing.assert_allclose(ours[name], theirs[name], atol=TOL, err_msg=name)
            compared += name != "world"
        np.testing.assert_allclose(arm.fk(theta), theirs[arm.tip], atol=TOL)
    for i in range(model.njnt):
        joint = arm.description.joints.get(name := model.joint(i).name)
        if joint is not None and joint.moving:
            bounds = model.jnt_range[i] if model.jnt_limited[i] else (-np.inf, np.inf)
            np.testing.assert_allclose((joint.lower, joint.upper), bounds, atol=TOL, err_msg=name)
            if model.jnt_actfrclimited[i]:
                assert joint.effort == np.abs(model.jnt_actfrcrange[i]).max()
    masses = bodies(arm.description)
    for i in range(1, model.nbody):
        name, R = model.body(i).name, np.empty(9)
        if name in arm.description.links and (name in masses or model.body_mass[i]):
            mujoco.mju_quat2Mat(R, model.body_iquat[i])
            inertia = R.reshape(3, 3) @ np.diag(model.body_inertia[i]) @ R.reshape(3, 3).T
            assert masses[name].mass == pytest.approx(model.body_mass[i], rel=TOL)
            np.testing.assert_allclose(masses[name].centre, model.body_ipos[i], atol=TOL)
            np.testing.assert_allclose(masses[name].inertia, inertia, atol=TOL)
    return compared


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_a_file_is_what_mujoco_makes_of_it(path: Path) -> None:
    model = mujoco.MjModel.from_xml_path(str(path))
    named = {model.body(i).name for i in range(1, model.nbody)} | {model.site(i).name for i in range(model.nsite)}
    assert require_as_mujoco(load_arm(path), path, 20) == 20 * len(named - {"", "box", "target"})  # not of the arm


@pytest.mark.parametrize("seed", [*range(40), *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(40, 100))])
def test_a_random_file_is_what_mujoco_makes_of_it(seed: int, tmp_path: Path) -> None:
    path, written = tmp_path / "arm.xml", Random(seed)
    path.write_text(written.text())
    assert require_as_mujoco(load_arm(path, tip=written.tip), path, 5) > 0


def test_the_crosscheck_has_no_second_account_of_mujoco() -> None:
    result = crosscheck(load_arm(file("several_joints")), 20)
    assert result.ok
    assert 0 < result.worst("pinocchio") < TOL
    assert "mujoco" in result.left_out


def test_without_mujoco_one_sentence_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(MissingExtraError, match=r"twistarm\[mjcf\]"):
        load_arm(file("ball"))


def test_a_scene_gives_tool_poses_pairs_and_efforts() -> None:
    """Its values are those that one reads in the files."""
    arm = load_arm(file("scene"))
    assert (arm.name, arm.base, arm.tip) == ("scene", "world", "pinch")
    assert arm.joint_names == ("joint1", "joint2", "joint3", "joint4")
    assert arm.limits.effort.tolist() == [87.0, 60.0, 2 * 87.0, 12.0]
    states = {name: theta.tolist() for name, theta in arm.named_states.items()}
    assert states == {"home": [0.0, -0.5, 1.0, 0.2], "up": [0.0, 0.0, 0.0, 0.0], "bent": [0.1, 0.2, 0.3, 0.4]}
    assert arm.disabled_collisions == {("link1", "link3")}
    assert not arm.description.links.keys() & {"box", "target"}
    assert arm.couplings["finger_joint2"] == ("finger_joint1", 1.0, 0.0)
    assert {one.code for one in arm.findings} >= {"mjcf-scenery-left-out", "srdf-found", "ready-named"}
    assert pickle.loads(pickle.dumps(arm)).description.gravity == (0.0, 0.0, -9.81)


def test_keyframes_without_name_or_joints_are_poses() -> None:
    """A key without qpos is MuJoCo's rest. j3 and j4 are set by the couplings."""
    model = mujoco.MjModel.from_xml_path(file("overrides"))
    states = load_arm(file("overrides")).named_states
    assert {name: theta.tolist() for name, theta in states.items()} == {
        "key0": model.key_qpos[0, :2].tolist(),
        "rest": pytest.approx(model.key_qpos[1, :2].tolist()),
    }


def test_a_ball_stands_still_and_is_named() -> None:
    arm = load_arm(file("ball"))
    assert (arm.joint_names, arm.named_states["home"].tolist()) == (("turn", "elbow"), [0.1, 0.7])
    (finding,) = (one for one in arm.findings if one.code == "mjcf-part-not-read")
    assert "'shoulder'" in finding.what


def test_shapes_are_those_of_mujoco() -> None:
    links = load_arm(file("scene")).description.links
    (wedge,), (cap,) = links["base"].visuals, links["link2"].visuals
    assert (wedge.mesh, wedge.size) == (DATA / "assets" / "wedge.obj", (0.1, 0.1, 0.2))
    assert wedge.colour == (0.9, 0.9, 0.9, 1.0)
    (rod,) = links["link1"].collisions
    assert (rod.shape, rod.size, rod.origin[2, 3]) == ("capsule", (0.04, pytest.approx(0.2)), pytest.approx(0.1))
    assert not links["base"].collisions
    assert not links["link1"].visuals
    # MuJoCo keeps a mesh in its inertial frame: the vertices in the body's frame are the same.
    model = mujoco.MjModel.from_xml_path(file("scene"))
    geom = int(np.argmax(model.geom_dataid == model.mesh("cap").id))
    R = np.empty(9)
    mujoco.mju_quat2Mat(R, model.geom_quat[geom])
    first = model.mesh_vertadr[model.geom_dataid[geom]]
    theirs = model.mesh_vert[first : first + 4] @ R.reshape(3, 3).T + model.geom_pos[geom]
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]) * cap.size
    ours = corners @ cap.origin[:3, :3].T + cap.origin[:3, 3]
    assert all(np.abs(theirs - corner).max(axis=1).min() < 1e-6 for corner in ours)  # meshes are single precision


ONE = '<body name="a"><joint name="j"/><geom size="0.1"/>{}</body>'


def refused(text: str, path: Path) -> Finding:
    """The first finding about an MJCF that cannot be used."""
    path.write_text(f"<mujoco>{text}</mujoco>")
    with pytest.raises(DescriptionError) as caught:
        load_arm(path)
    return caught.value.findings[0]


@pytest.mark.parametrize(
    ("part", "tag"),
    [
        ('<joint type="cart"/>', "joint"),
        ('<site name="s" quat="0 0 0 0"/>', "site"),
        ('<joint name="k" class="none"/>', "joint"),
        ('<geom type="box" size="1"/>', "geom"),
        ('<geom mesh="lost"/>', "geom"),
        ('<body pos="1 2"/>', "body"),
        ("<joint name='k' axis='0 0 0'/>", "joint"),
        ('<joint name="k" rang="0 1"/>', "joint"),
        ('<jnt name="k"/>', "jnt"),
        ('<include file="lost.xml"/>', "include"),
        ('<include file="arm.xml"/>', "include"),
    ],
)
def test_an_unusable_element_has_its_line(part: str, tag: str, tmp_path: Path) -> None:
    whole = ONE.format("<!--\n-->" + part)
    found = refused(f"<worldbody>\n{whole}</worldbody>", tmp_path / "arm.xml")
    assert (found.code, found.place.file, found.place.line, found.place.element) == ("mjcf-unusable", "arm.xml", 3, tag)


HEAVY = '<geom type="box" size="1 1 1" mass="-2"/>'


@pytest.mark.parametrize(
    ("text", "code"),
    [
        (f"<worldbody>{ONE.format('') * 4001}</worldbody>", "mjcf-unusable"),  # one name for all
        (f"<worldbody>{ONE.format(HEAVY)}</worldbody>", "mjcf-unusable"),
        (f'<compiler angle="radians"/><worldbody>{ONE.format("")}</worldbody>', "mjcf-unusable"),
        ('<worldbody><include file="../../../../../../../etc/passwd"/></worldbody>', "file-outside-packages"),
        ('<asset><model name="m" file="arm.xml"/></asset>', "mjcf-unusable"),
        ('<asset><model name="m" file="pipe.xml"/></asset>', "file-unreadable"),
        ('<asset><model name="m" file="out.xml"/></asset>', "file-outside-packages"),
        ("", "no-chain"),
    ],
)
def test_a_file_that_is_no_use_is_refused(text: str, code: str, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.xml")
    (tmp_path / "out.xml").symlink_to(DATA / "ball.xml")
    assert refused(text, tmp_path / "arm.xml").code == code


def told(text: str, folder: Path) -> dict[str, str]:
    """What the findings about a whole MJCF say, by their code."""
    path = folder / "arm.txt"  # known by its content
    path.write_text(f"<mujoco>{text}</mujoco>")
    return {one.code: one.what for one in load_arm(path).findings if one.code.startswith("mjcf")}


PLUGIN = '<plugin plugin="mujoco.elasticity.cable"/>'


@pytest.mark.parametrize(
    ("part", "beside", "code", "named"),
    [
        (f'<composite type="cable" count="3 1 1" prefix="rope">{PLUGIN}</composite>', "", "mjcf-part-not-read", "rope"),
        ('<body name="b"><geom size="1"/><joint type="ball" range="0 1"/></body>', "", "mjcf-part-not-read", "b_joint"),
        (
            "",
            '<tendon><fixed name="split"><joint joint="j" coef="1"/></fixed></tendon>',
            "mjcf-scenery-left-out",
            "split",
        ),
        ('<geom type="ellipsoid" size="1 1 1"/>', "", "mjcf-scenery-left-out", "ellipsoid"),
        ("", '<option gravity="0 -9.81 0"/>', "mjcf-gravity", "-9.81"),
    ],
)
def test_what_is_left_out_is_told(part: str, beside: str, code: str, named: str, tmp_path: Path) -> None:
    assert named in told(f"{beside}<worldbody>{ONE.format(part)}</worldbody>", tmp_path)[code]
    assert not told(f"<worldbody>{ONE.format('')}</worldbody>", tmp_path)


@pytest.mark.parametrize(
    "coupling",
    [
        '<joint name="c" joint1="j" joint2="k" polycoef="0 1 2"/>',
        '<joint joint1="j" joint2="k"/><joint name="c" joint1="j" joint2="l"/>',
        '<joint joint1="j" joint2="k"/><joint name="c" joint1="k" joint2="j"/>',
        '<weld name="c" body1="a" body2="b"/>',
    ],
)
def test_a_coupling_that_is_not_kept_is_named(coupling: str, tmp_path: Path) -> None:
    more = '<body name="b"><joint name="k"/><joint name="l" axis="0 1 0"/><geom size="0.1"/></body>'
    text = f"<worldbody>{ONE.format(more)}</worldbody><equality>{coupling}</equality>"
    assert "> c: " in told(text, tmp_path)["mjcf-loop-open"]


MESHES = """<compiler meshdir="{folder}"/><asset><mesh name="m" file="{file}"/></asset>
<worldbody><body name="a"><joint name="j" range="-9 9"/>{mass}<geom type="mesh" mesh="m"/></body></worldbody>"""
WEIGHED = '<inertial pos="0 0 0" mass="2" diaginertia="1 1 1"/>'


@pytest.mark.parametrize(
    ("file", "mass", "codes", "weighs"),
    [
        ("lost.stl", WEIGHED, {"mesh-missing"}, 2.0),
        ("lost.stl", "", {"mesh-missing", "mjcf-part-not-read"}, None),
        ("broken.stl", WEIGHED, set(), 2.0),
        ("broken.stl", "", {"mjcf-part-not-read"}, None),
        ("pipe.stl", "", {"mesh-missing", "mjcf-part-not-read"}, None),
        ("wedge.stl", "", set(), 1000 / 6),
    ],
)
def test_an_arm_loads_without_its_meshes(
    file: str, mass: str, codes: set[str], weighs: float | None, tmp_path: Path
) -> None:
    folder = tmp_path / "meshes"
    folder.mkdir()
    os.mkfifo(folder / "pipe.stl")
    (folder / "broken.stl").write_text("version https://git-lfs.github.com/spec/v1")
    (folder / "wedge.stl").write_bytes((DATA / "assets" / "wedge.stl").read_bytes())
    (tmp_path / "arm.xml").write_text(f"<mujoco>{MESHES.format(folder='meshes', file=file, mass=mass)}</mujoco>")
    arm = load_arm(tmp_path / "arm.xml")
    assert {one.code for one in arm.findings} & {"mesh-missing", "mjcf-part-not-read"} == codes
    body = bodies(arm.description).get("a")
    assert (None if body is None else body.mass) == (None if weighs is None else pytest.approx(weighs, rel=1e-6))


@pytest.mark.parametrize("path", RATES_ALIKE, ids=lambda path: path.stem)
def test_torques_hold_the_arm_in_the_gravity_of_the_file(path: Path) -> None:
    """MuJoCo's own inverse dynamics at rest. Coordinates of followers are others than MuJoCo's."""
    arm, model = load_arm(path), mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    dofs = [model.jnt_dofadr[mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, name)] for name in arm.joint_names]
    for theta in arm.random_theta(1, 5):
        moved(model, data, arm, theta)
        mujoco.mj_forward(model, data)
        np.testing.assert_allclose(arm.inverse_dynamics(theta), data.qfrc_bias[dofs], atol=1e-9)


def test_gravity_is_in_axes_of_the_base() -> None:
    arm = load_arm(file("attached"), base="upper")
    whole = load_arm(file("attached"))
    g = whole.poses(np.zeros(whole.n))["upper"]
    np.testing.assert_allclose(g[:3, :3] @ arm.gravity, [1.0, -9.0, 2.0], atol=TOL)
    assert load_arm("rover_arm").gravity.tolist() == [0.0, 0.0, -9.81]


def test_ctrl_c_ends_a_compilation(tmp_path: Path) -> None:
    """The process is not in Python then, and ends by the signal itself."""
    before = signal.getsignal(signal.SIGINT)
    with ending_at_once():
        assert signal.getsignal(signal.SIGINT) is signal.SIG_DFL
    assert signal.getsignal(signal.SIGINT) is before


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_damaged_files_never_give_a_traceback(path: Path, tmp_path: Path) -> None:
    rng = random.Random(path.stem)
    words = ["", "nan", "1e400", "-1", "a", "0 0 0", "1 2", "inf inf inf", "world", "main", "true", "<", "&x;"]
    text = path.read_text()
    for folder in ("parts", "assets"):
        (tmp_path / folder).symlink_to(DATA / folder)
    for _ in range(40):
        parts = text.split('"')
        for _ in range(rng.randint(1, 3)):
            parts[rng.randrange(1, len(parts), 2)] = rng.choice([*words, rng.choice(parts[1::2])])
        damaged = '"'.join(parts)
        if rng.random() < 0.3:
            lines = damaged.splitlines()
            del lines[rng.randrange(len(lines))]
            damaged = "\n".join(lines)
        (tmp_path / "arm.xml").write_text(damaged)
        with contextlib.suppress(TwistarmError):
            load_arm(tmp_path / "arm.xml")
