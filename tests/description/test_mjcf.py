"""MJCF against MuJoCo's own kinematics, compiler and masses; and files that are no use."""

from __future__ import annotations

import contextlib
import pickle
import random
import sys
from pathlib import Path

import mujoco
import numpy as np
import pytest

from twistarm import Arm, crosscheck, load_arm
from twistarm.description.inertial import bodies
from twistarm.description.mjcf.schema import ATTRIBUTES
from twistarm.support.errors import DescriptionError, TwistarmError

DATA = Path(__file__).parents[1] / "data" / "mjcf"
FILES = sorted(DATA.glob("*.xml"))
TOL = 1e-12
UNNAMED = "body10_joint"
"""What a joint of the body without a name is called in several_joints.xml."""


def file(name: str) -> str:
    return str(DATA / f"{name}.xml")


def turned(axis: int, angle: float) -> np.ndarray:
    c, s, i, j = np.cos(angle), np.sin(angle), (axis + 1) % 3, (axis + 2) % 3
    R = np.eye(3)
    R[i, i] = R[j, j] = c
    R[j, i], R[i, j] = s, -s
    return R


def moved(model: mujoco.MjModel, data: mujoco.MjData, arm: Arm, theta: np.ndarray) -> dict[str, np.ndarray]:
    """The pose of each named body and site. Joints outside `theta` stand at 0, and followers as `equality` says."""
    values = dict(zip(arm.joint_names, theta, strict=True))
    data.qpos[:] = model.qpos0
    for i in range(model.njnt):
        at, name = model.jnt_qposadr[i], model.joint(i).name
        if model.jnt_type[i] == mujoco.mjtJoint.mjJNT_BALL:
            R = turned(2, values[f"{name}_rz"]) @ turned(1, values[f"{name}_ry"]) @ turned(0, values[f"{name}_rx"])
            mujoco.mju_mat2Quat(data.qpos[at : at + 4], R.ravel())
        elif model.jnt_type[i] != mujoco.mjtJoint.mjJNT_FREE:
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


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_every_body_and_site_stands_where_mujoco_puts_it(path: Path) -> None:
    arm = load_arm(path)
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    compared = 0
    for theta in arm.random_theta(0, 20):
        theirs, ours = moved(model, data, arm, theta), arm.poses(theta)
        for name in theirs.keys() & ours.keys():
            np.testing.assert_allclose(ours[name], theirs[name], atol=TOL, err_msg=name)
            compared += name != "world"
        np.testing.assert_allclose(arm.fk(theta), theirs[arm.tip], atol=TOL)
    named = {model.body(i).name for i in range(1, model.nbody)} | {model.site(i).name for i in range(model.nsite)}
    assert compared == 20 * len(named - {"", "box", "target"})  # not of the arm


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_limits_and_masses_are_those_of_mujocos_compiler(path: Path) -> None:
    arm = load_arm(path)
    model = mujoco.MjModel.from_xml_path(str(path))
    for i in range(model.njnt):
        name = model.joint(i).name
        joint = arm.description.joints.get(name)
        if joint is not None and joint.moving:
            bounds = model.jnt_range[i] if model.jnt_limited[i] else (-np.inf, np.inf)
            np.testing.assert_allclose((joint.lower, joint.upper), bounds, atol=TOL, err_msg=name)
    masses = bodies(arm.description)
    for i in range(1, model.nbody):
        if (body := masses.get(model.body(i).name)) is not None:
            R = np.empty(9)
            mujoco.mju_quat2Mat(R, model.body_iquat[i])
            R = R.reshape(3, 3)
            assert body.mass == pytest.approx(model.body_mass[i], abs=TOL)
            np.testing.assert_allclose(body.centre, model.body_ipos[i], atol=TOL)
            np.testing.assert_allclose(body.inertia, R @ np.diag(model.body_inertia[i]) @ R.T, atol=TOL)
    assert set(masses) >= {
        model.body(i).name for i in range(1, model.nbody) if model.body(i).name in ("a", "link1", "plate")
    }


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_the_crosscheck_asks_mujoco(path: Path) -> None:
    result = crosscheck(load_arm(path), 20)
    assert result.ok
    assert "mujoco" not in result.left_out
    assert 0 < result.worst("mujoco") < TOL


def test_without_mujoco_the_crosscheck_names_its_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "mujoco", None)
    result = crosscheck(load_arm(file("ball")), 5)
    assert "pip install 'twistarm[mjcf]'" in result.left_out["mujoco"]


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
    assert pickle.loads(pickle.dumps(arm)).description.mjcf == arm.description.mjcf


def test_keyframes_without_name_or_joints_are_poses() -> None:
    """A key without qpos is MuJoCo's rest. j3 and j4 are set by the couplings."""
    model = mujoco.MjModel.from_xml_path(file("overrides"))
    states = load_arm(file("overrides")).named_states
    assert {name: theta.tolist() for name, theta in states.items()} == {
        "key0": model.key_qpos[0, :2].tolist(),
        "rest": pytest.approx(model.key_qpos[1, :2].tolist()),
    }


def test_a_key_without_joints_is_the_rest_of_a_ball_too() -> None:
    assert load_arm(file("ball")).named_states["rest"].tolist() == [0.0] * 5


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


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (ONE.format("") * 4001, "at most 4,000"),
        (ONE.format('<joint type="cart"/>'), "joint type 'cart'"),
        (ONE.format('<site name="s" quat="0 0 0 0"/>'), "site 's'"),
        (ONE.format('<joint name="k" class="none"/>'), "class 'none' does not exist"),
        (ONE.format('<geom type="box" size="1"/>'), "needs a size of 3"),
        (ONE.format('<geom type="capsule" size="-1 2" mass="2"/>'), "none negative"),
        (ONE.format('<geom mesh="lost"/>'), "'lost'"),
        (ONE.format('<body pos="1 2"/>'), "3 finite numbers"),
        (ONE.format('<geom type="box" size="1 1 1" mass="-2"/>'), "must not be negative"),
        ('</worldbody><compiler angle="radians"/><worldbody>', "'radians' is none of degree, radian"),
        ('</worldbody><compiler coordinate="global"/><worldbody>', "'global' is none of local"),
        ('</worldbody><compiler boundmass="-1"/><worldbody>' + ONE.format(""), "must not be negative"),
        ('<include file="lost.xml"/>', "lost.xml"),
        ('<include file="../../../../../../../etc/passwd"/>', "outside the folders"),
        ('<include file="arm.xml"/>', "included already"),
        (ONE.format("<joint name='k' axis='0 0 0'/>"), "zero axis"),
    ],
)
def test_unusable_files_are_told_in_a_sentence(text: str, said: str, tmp_path: Path) -> None:
    path = tmp_path / "arm.xml"
    path.write_text(f"<mujoco><worldbody>{text}</worldbody></mujoco>")
    with pytest.raises(DescriptionError, match=said):
        load_arm(path)


def told(text: str, folder: Path) -> str:
    """What the findings about a whole MJCF say."""
    path = folder / "arm.txt"  # known by its content
    path.write_text(f"<mujoco>{text}</mujoco>")
    return " ".join(one.what for one in load_arm(path).findings if one.code.startswith("mjcf"))


@pytest.mark.parametrize(
    ("part", "beside", "named"),
    [
        ('<replicate count="3"/>', "", "replicate"),
        ('<geom size="0.1" shellinertia="true"/>', "", "the mass"),
        ('<geom type="box" mesh="m"/>', '<asset><mesh name="m" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/></asset>', "the mass"),
        ('<body name="b"><joint type="ball" range="0 1"/></body>', "", "ball"),
        ("", '<compiler settotalmass="5"/>', "settotalmass"),
        ("", '<tendon><fixed name="split"><joint joint="j" coef="1"/></fixed></tendon>', "split"),
        ("", '<actuator><position joint="j" ctrlrange="-0.2 0.3"/></actuator>', "-0.2 to 0.3"),
        ('<jnt name="k"/>', "", "'joint'"),
        ('<body name="b"><joint name="k" rang="0 1"/></body>', "", "'range'"),
        ('<site name="s" poss="0 0 1"/>', "", "'pos'"),
        ("", '<compiler eulerseqs="xyz"/>', "'eulerseq'"),
        ("", '<default><default class="arm"><joint axiss="0 1 0"/></default></default>', "'axis'"),
        ('<body name="b"><joint name="k"/></body>', '<equality><joint joint1="j" jointt2="k"/></equality>', "'joint2'"),
    ],
)
def test_what_is_not_read_is_told(part: str, beside: str, named: str, tmp_path: Path) -> None:
    assert named in told(f"{beside}<worldbody>{ONE.format(part)}</worldbody>", tmp_path)
    assert not told(f"<worldbody>{ONE.format('')}</worldbody>", tmp_path)


@pytest.mark.parametrize(
    ("couplings", "reason"),
    [
        ('<joint joint1="j" joint2="lost"/>', "'lost' is no hinge or slide"),
        ('<joint joint1="j" joint2="k" polycoef="0 1 2"/>', "not linear"),
        ('<joint joint1="j" joint2="k"/><joint joint1="j" joint2="l"/>', "moves 'j' already"),
        ('<joint joint1="j" joint2="k"/><joint joint1="k" joint2="j"/>', "'j' follows 'k'"),
        ('<weld body1="a" body2="b"/>', "not between joints"),
    ],
)
def test_a_coupling_that_is_not_kept_has_its_reason(couplings: str, reason: str, tmp_path: Path) -> None:
    more = '<body name="b"><joint name="k"/><joint name="l" axis="0 1 0"/><geom size="0.1"/></body>'
    text = f"<worldbody>{ONE.format(more)}</worldbody><equality>{couplings}</equality>"
    assert reason in told(text, tmp_path)


def test_a_file_without_bodies_is_told(tmp_path: Path) -> None:
    with pytest.raises(DescriptionError, match="no joint moves"):
        told("", tmp_path)


def test_each_word_of_mujocos_schema_is_known() -> None:
    words = mujoco.mj_printSchema(False, False).split()
    words = words[words.index("compiler") :]
    ends = {"body": "(world)body"}
    for tag in ("compiler", "body", "inertial", "joint", "geom", "site"):
        start = words.index(ends.get(tag, tag), 0 if tag in ("compiler", "body") else words.index("(world)body")) + 2
        end = next(i for i in range(start, len(words)) if words[i + 1].startswith("("))
        assert len(words[start:end]) > 5
        assert set(words[start:end]) <= set(ATTRIBUTES[tag].split()), tag


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
