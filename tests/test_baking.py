"""Baked arms: the same answers without Pinocchio and the description, and files that are refused in one line."""

from __future__ import annotations

import hashlib
import json
import pickle
import subprocess
import sys
import zlib
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from catalogue import load
from twistarm import Arm, ArmBuilder, JointLimits, arm_from_screws, diagnose, load_arm, plan_joint, solve_ik
from twistarm.baking import MAX_BYTES
from twistarm.cli.application import run
from twistarm.errors import DescriptionError, InputError, TwistarmError, UnknownNameError
from twistarm.limits import FIELDS
from urdf_text import joint, robot, write

TOL = 1e-12

EVERYTHING = """
source = "arm.urdf"
name = "everything"

[tool]
name = "gripper"
xyz = [0.0, 0.01, 0.12]
rpy = [0.0, 0.1, 0.0]

[poses]
ready = { a = 0.1, c = -0.2 }
home = { a = 0.0, c = 0.0 }

[actuators.left]
ratio = { a = 9.0, c = 3.0 }
offset = 0.25
unit = "tick"
ticks_per_turn = 4096

[actuators.right]
ratio = { a = -9.0, c = 3.0 }
limits = { lower = -40.0, velocity = 0.1, acceleration = 3.5, effort = 2.0 }
"""

SRDF = """<robot name="tiny"><disable_collisions link1="upper" link2="base_link" reason="Adjacent"/></robot>"""


@pytest.fixture
def everything(tmp_path: Path) -> Arm:
    """A follower, a locked offset, a tool, poses, motors, an SRDF."""
    links = ("base_link", "upper", "fore", "tool0")
    follows = '<axis xyz="0 1 0"/><mimic joint="a" multiplier="-0.5" offset="0.3"/>'
    parts = [
        joint("a", "base_link", "upper", xyz="0.1 0 0.3", rpy="0.2 0 0"),
        joint("b", "upper", "fore", inside=follows, xyz="0.4 0 0"),
        joint("c", "fore", "tool0", kind="continuous", inside='<axis xyz="1 0 0"/>', xyz="0.3 0 0"),
    ]
    write(tmp_path, robot(*parts, links=links))
    write(tmp_path, SRDF, "tiny.srdf")
    return load_arm(write(tmp_path, EVERYTHING, "arm.toml"))


def bake(arm: Arm, folder: Path) -> Path:
    return arm.bake(folder / "baked.json")


# -- the same arm ------------------------------------------------------------------------------------------------


def assert_same(baked: Arm, arm: Arm) -> None:
    """Everything about the chain, bit for bit where it is data."""
    left_out = {"source", "findings", "description", "couplings"}
    for name in {field.name for field in fields(Arm)} - left_out:
        one, other = getattr(baked, name), getattr(arm, name)
        if name == "limits":
            assert all(np.array_equal(getattr(one, field), getattr(other, field)) for field in FIELDS)
        elif name == "coupling":
            assert all(np.array_equal(a, b) for a, b in zip(one, other, strict=True))
        elif name == "named_states":
            assert list(one) == list(other)
            assert all(np.array_equal(one[key], other[key]) for key in other)
        elif name == "actuators":
            assert (one is None) == (other is None)
            if one is not None:
                assert all(np.array_equal(getattr(one, key), getattr(other, key))
                           for key in ("names", "joint_names", "G", "offset", "units"))  # fmt: skip
                assert np.array_equal(one.ticks_per_turn, other.ticks_per_turn, equal_nan=True)
                assert all(np.array_equal(getattr(one.limits, f), getattr(other.limits, f)) for f in FIELDS)
        else:
            assert np.array_equal(one, other), name
    assert np.array_equal(baked.ready, arm.ready)
    assert np.array_equal(baked.usual_half, arm.usual_half)
    assert baked.units == arm.units
    assert baked.frame_names == (arm.base, arm.tip)


def assert_same_answers(baked: Arm, arm: Arm) -> None:
    """Against Pinocchio's own account."""
    theta = arm.random_theta(np.random.default_rng(3), 12)
    assert np.array_equal(baked.random_theta(np.random.default_rng(3), 12), theta)
    model = arm.pinocchio
    for row in theta:
        spatial = model.spatial_jacobian(row, arm.base, arm.tip_link)
        g = model.link_pose(model.q(row), arm.base, arm.tip_link) @ arm.tool
        assert np.abs(baked.fk(row) - g).max() < TOL
        assert np.abs(baked.spatial_jacobian(row) - spatial).max() < TOL
        assert np.abs(baked.body_jacobian(row) - arm.body_jacobian(row)).max() < TOL
    mine, theirs = baked.manipulability(theta), arm.manipulability(theta)
    assert np.abs(mine.singular_values - theirs.singular_values).max() < TOL


def test_every_arm_of_the_catalogue(catalogue_arm: Arm, tmp_path: Path) -> None:
    baked = load_arm(bake(catalogue_arm, tmp_path))
    assert_same(baked, catalogue_arm)
    assert_same_answers(baked, catalogue_arm)


def test_all_that_an_arm_may_have(everything: Arm, tmp_path: Path) -> None:
    """Followers, a tool of the arm.toml, motors with and without ticks, poses, pairs that need no check."""
    assert everything.moving_names == ("a", "b", "c")
    assert everything.disabled_pairs
    assert everything.actuators is not None
    path = bake(everything, tmp_path)
    baked = load_arm(path)
    assert baked.source == "arm.toml"
    assert_same(baked, everything)
    assert_same_answers(baked, everything)
    assert str(tmp_path) not in path.read_text("utf-8")


def test_a_file_from_before_motors_had_limits(everything: Arm, tmp_path: Path) -> None:
    path = bake(everything, tmp_path)
    content = json.loads(path.read_text("utf-8"))
    assert content["actuators"]["limits"]["velocity"] == [None, 0.1]
    del content["actuators"]["limits"]
    path.write_text(sealed(content))
    motors = load_arm(path).actuators
    assert motors is not None
    assert np.isinf(motors.limits.velocity).all()


def test_baked_again_it_is_the_same_file(everything: Arm, tmp_path: Path) -> None:
    first = bake(everything, tmp_path).read_bytes()
    again = load_arm(tmp_path / "baked.json")
    assert again.bake(tmp_path / "again.json").read_bytes() == first
    assert pickle.loads(pickle.dumps(again)).bake(tmp_path / "pickled.json").read_bytes() == first


def test_arms_without_a_description(tmp_path: Path) -> None:
    home = np.eye(4)
    home[:3, 3] = (0.3, 0.0, 0.7)
    arm = arm_from_screws(np.eye(6)[:, [2, 3, 5]], home, name="ärmchen", limits={"velocity": 0.1 + 0.2})
    baked = load_arm(bake(arm, tmp_path))
    assert_same(baked, arm)
    with pytest.raises(TwistarmError, match="ärmchen was made from screws, not from a description"):
        _ = baked.pinocchio


def test_a_thread_keeps_its_range(tmp_path: Path) -> None:
    """`usual_half` of a helical coordinate follows from its pitch."""
    arm = ArmBuilder("screw").helical("thread", (0, 0, 1), (0, 0, 0), 0.02).tool(np.eye(4)).build()
    baked = load_arm(bake(arm, tmp_path))
    assert baked.usual_half.tolist() == [50.0]
    assert_same(baked, arm)


def test_a_tool_on_a_baked_arm(rover: Arm, tmp_path: Path) -> None:
    g = np.eye(4)
    g[:3, 3] = (0.0, 0.0, 0.1)
    baked = load_arm(bake(rover, tmp_path)).with_tool(g, "pen")
    assert np.abs(baked.fk(rover.ready) - rover.fk(rover.ready) @ g).max() < TOL
    assert_same(load_arm(bake(baked, tmp_path)), baked)


def test_the_ready_pose_is_the_one_in_the_file(rover: Arm, tmp_path: Path) -> None:
    """It is not found anew: which posture is best may hang on an engine's rounding."""
    path = bake(rover, tmp_path)
    content = json.loads(path.read_text("utf-8"))
    del content["named_states"]["ready"]
    content["ready"] = [0.125, 0.0, 0.5, 0.0, 1.0]
    path.write_text(sealed(content))
    ready = load_arm(path).ready
    assert ready.tolist() == [0.125, 0.0, 0.5, 0.0, 1.0]
    assert not ready.flags.writeable


# -- without Pinocchio -------------------------------------------------------------------------------------------

ALONE = """
import sys

class Refusal:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in ("pinocchio", "xacro", "yaml", "typer", "rich", "scipy", "cmeel", "meshcat"):
            raise ModuleNotFoundError(f"{name} is not for a baked arm", name=name)

sys.meta_path.insert(0, Refusal())
import json
import numpy as np
import twistarm

arm = twistarm.load_arm(sys.argv[1])
theta = arm.random_theta(np.random.default_rng(1), 5)
targets = [arm.fk(row) for row in theta]
found = [twistarm.solve_ik(arm, target) for target in targets]
try:
    arm.pinocchio
    lack = ""
except twistarm.TwistarmError as error:
    lack = str(error)
print(json.dumps({
    "fk": arm.fk(theta).tolist(),
    "spatial": arm.spatial_jacobian(theta).tolist(),
    "body": arm.body_jacobian(theta).tolist(),
    "singular_values": arm.manipulability(theta).singular_values.tolist(),
    "answers": [solution.theta.tolist() for solution in found],
    "converged": [solution.converged for solution in found],
    "lack": lack,
    "needless": sorted({"twistarm.doctor", "twistarm.golden", "twistarm.viewer", "urllib.request"} & set(sys.modules)),
}))
"""


@pytest.mark.parametrize("core", [True, False], ids=["with the core", "without"])
@pytest.mark.parametrize("name", ["rover_arm", "panda"])
def test_without_pinocchio(name: str, core: bool, tmp_path: Path) -> None:
    """In a process that cannot import it, nor what reads descriptions; the full arm's Pinocchio judges."""
    arm = load(name)
    hidden = "" if core else "import sys; sys.modules['twistarm._core'] = None\n"
    command = [sys.executable, "-c", hidden + ALONE, str(bake(arm, tmp_path))]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout)
    theta = arm.random_theta(np.random.default_rng(1), 5)
    model = arm.pinocchio
    g, J = (
        np.array(parts)
        for parts in zip(*(model.pose_and_body_jacobian(row, arm.base, arm.tip_link) for row in theta), strict=True)
    )
    spatial = [model.spatial_jacobian(row, arm.base, arm.tip_link) for row in theta]
    assert np.abs(np.array(said["fk"]) - g).max() < TOL
    assert np.abs(np.array(said["body"]) - J).max() < TOL
    assert np.abs(np.array(said["spatial"]) - spatial).max() < TOL
    values = np.linalg.svd(scaled(arm, J), compute_uv=False)
    assert np.abs(np.array(said["singular_values"]) - values).max() < TOL
    assert all(said["converged"])
    assert said["needless"] == []
    for answer, target in zip(np.array(said["answers"]), g, strict=True):
        reached, _ = model.pose_and_body_jacobian(answer, arm.base, arm.tip_link)
        assert np.abs(reached - target).max() < 2e-6
        assert arm.limits.contains(answer)
    assert (
        said["lack"] == f"{name} was baked without its description (load {name!r} for that): it has no Pinocchio model"
    )


def scaled(arm: Arm, J: np.ndarray) -> np.ndarray:
    """Linear rows by the reach, columns of slides times the reach."""
    rows = np.array([1 / arm.reach] * 3 + [1.0] * 3)
    columns = np.array([arm.reach if unit == "m" else 1.0 for unit in arm.units])
    return J * rows[:, None] * columns


def test_planning_and_inverse_kinematics(rover: Arm, tmp_path: Path) -> None:
    baked = load_arm(bake(rover, tmp_path))
    goal = rover.fk(rover.named_states["reach"])
    found, whole = solve_ik(baked, goal), solve_ik(rover, goal)
    assert found.converged
    assert np.abs(found.theta - whole.theta).max() < 1e-6
    path = [baked.ready, baked.named_states["reach"]]
    assert plan_joint(baked, path).duration == pytest.approx(plan_joint(rover, path).duration)


@pytest.mark.parametrize(
    ("ask", "error"),
    [
        (lambda arm: arm.pinocchio, "rover_arm was baked without its description (load 'rover_arm' for that): "
         "it has no Pinocchio model"),
        (lambda arm: arm.gravity_torques(arm.ready), "rover_arm was baked without its description (load 'rover_arm' "
         "for that): it has no Pinocchio model"),
        (lambda arm: arm.pose(arm.ready, "forearm"), "no frame 'forearm' in rover_arm, baked without its description "
         "(load 'rover_arm' for that) (2 frames: arm.frame_names)"),
    ],
    ids=["pinocchio", "gravity", "another link"],
)  # fmt: skip
def test_what_needs_the_description_says_so(
    ask: Callable[[Arm], object], error: str, rover: Arm, tmp_path: Path
) -> None:
    with pytest.raises(TwistarmError) as caught:
        ask(load_arm(bake(rover, tmp_path)))
    assert str(caught.value) == error


# -- limits, and what cannot be asked ----------------------------------------------------------------------------


def test_limits_are_taken(rover: Arm, tmp_path: Path) -> None:
    """As for the description; named poses that lie outside are left out and said, and `ready` is found anew."""
    path = bake(rover, tmp_path)
    slower = load_arm(path, limits={"velocity": 0.25})
    assert slower.limits.velocity.tolist() == [0.25] * 5
    assert list(slower.named_states) == list(rover.named_states)
    narrow = load_arm(path, limits={"upper": {"elbow": 1.0}})
    assert list(narrow.named_states) == ["reach"]
    assert [finding.code for finding in narrow.findings] == ["state-outside-limits"] * 2
    assert narrow.limits.contains(narrow.ready)
    every = load_arm(path, limits=JointLimits.unbounded(5))
    assert np.isinf(every.limits.upper).all()
    write(tmp_path, "joint_limits: {elbow: {max_velocity: 0.125, has_velocity_limits: true}}", "limits.yaml")
    assert load_arm(path, limits=tmp_path / "limits.yaml").limits.velocity[2] == 0.125
    with pytest.raises(UnknownNameError, match="no joint 'elbo' in limits"):
        load_arm(path, limits={"upper": {"elbo": 1.0}})


@pytest.mark.parametrize(
    ("name", "wish"),
    [
        ("base", "shoulder_link"),
        ("tip", "forearm"),
        ("locked", {"elbow": 1.0}),
        ("srdf", "arm.srdf"),
        ("package_dirs", ["."]),
        ("xacro_args", {"reach": 1}),
    ],
)
def test_what_only_a_description_can_be_asked(name: str, wish: Any, rover: Arm, tmp_path: Path) -> None:
    path = bake(rover, tmp_path)
    with pytest.raises(InputError) as caught:
        load_arm(path, **{name: wish})
    assert str(caught.value) == f"{path}: {name} cannot be given for a baked arm, only for its description, 'rover_arm'"


def test_its_own_base_and_tip_may_be_named(rover: Arm, tmp_path: Path) -> None:
    assert_same(load_arm(bake(rover, tmp_path), base=rover.base, tip=rover.tip, package_dirs=(), xacro_args={}), rover)


def test_there_is_nothing_to_diagnose_in_the_file(rover: Arm, tmp_path: Path) -> None:
    path = bake(rover, tmp_path)
    with pytest.raises(InputError, match="baked.json is a baked arm, which has no description; give the file that it"):
        diagnose(path)
    assert isinstance(diagnose(load_arm(path)), tuple)


# -- files -------------------------------------------------------------------------------------------------------


def sealed(content: dict[str, Any]) -> str:
    """A file with a digest that fits, worked out as the format says: SHA-256 of the rest, sorted, without spaces."""
    rest = {key: value for key, value in content.items() if key not in ("format", "version", "digest")}
    digest = hashlib.sha256(json.dumps(rest, sort_keys=True, separators=(",", ":")).encode()).hexdigest()
    return json.dumps({**content, "digest": f"sha256:{digest}"})


def changed(path: Path, key: str, value: Any) -> str:
    """The file with another value, the digest fitting; `a.b` is b in a."""
    content = json.loads(path.read_text("utf-8"))
    *parents, last = key.split(".")
    inside = content
    for parent in parents:
        inside = inside[int(parent)] if isinstance(inside, list) else inside[parent]
    inside[last] = value
    return sealed(content)


def test_the_digest_is_what_the_format_says(rover: Arm, tmp_path: Path) -> None:
    path = bake(rover, tmp_path)
    content = json.loads(path.read_text("utf-8"))
    assert json.loads(sealed(content))["digest"] == content["digest"]
    path.write_text(sealed(content))
    assert_same(load_arm(path), rover)


def test_an_edited_number_is_refused(rover: Arm, tmp_path: Path) -> None:
    path = bake(rover, tmp_path)
    text = path.read_text("utf-8")
    path.write_text(text.replace("-1.57", "-1.58", 1))
    with pytest.raises(DescriptionError) as caught:
        load_arm(path)
    assert str(caught.value) == (
        f"{path}: edited or damaged since it was baked (its digest does not fit); bake it again from the description: "
        "twistarm bake ARM FILE --force"
    )


LIMITED = {
    "names": ["m"], "G": [[1.0] * 5], "offset": [0.0], "units": ["rad"], "ticks_per_turn": [None],
    "limits": {field: [None, None] for field in FIELDS},
}  # fmt: skip

REFUSED: dict[str, tuple[str, Any, str]] = {
    "names that are none": ("base", 5, "base must be text; got 5"),
    "a joint named twice": ("joints.1.name", "slide", "joints must be different names, at least one"),
    "no joints": ("joints", [], "joints must be different names, at least one"),
    "a type that is none": ("joints.0.type", "floating", "a joint is revolute, continuous, prismatic, helical, in rad"),
    "a slide in rad": ("joints.0.unit", "rad", "got 'prismatic' in 'rad'"),
    "limits that are swapped": ("joints.0.lower", 2.0, "limits of joint 0 are swapped"),
    "a limit that is no number": ("joints.0.upper", "far", "upper must be an array of real numbers"),
    "a negative velocity": ("joints.0.velocity", -1.0, "limits.velocity must not be negative"),
    "too few screws": ("screws", [[0.0, 1.0]] * 6, "screws must have shape (6, 5); got (6, 2)"),
    "a screw that is zero": ("screws", [[0.0] * 5] * 6, "a joint whose screw is zero"),
    "ragged screws": ("screws", [[0.0] * 5] * 5 + [[0.0]], "screws must be an array of real numbers"),
    "a home that is no pose": ("home", [[2.0, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]], "is not in SO(3)"),
    "a tool that is no pose": ("tool", np.zeros((4, 4)).tolist(), "tool is not in SE(3)"),
    "a coupling of another size": ("coupling.A", [[1.0]], "A must have shape (5, 5); got (1, 1)"),
    "no offsets": ("coupling", {"A": np.eye(5).tolist()}, "'b' is missing"),
    "no reach": ("reach", 0.0, "reach must be a positive number; got 0"),
    "ready of another size": ("ready", [0.0], "ready must have shape (5,); got (1,)"),
    "ready beyond the limits": ("ready", [9.0, 0.0, 0.0, 0.0, 0.0], "ready lies outside the limits"),
    "a pose of another size": ("named_states", {"up": [1.0]}, "pose up must have shape (5,); got (1,)"),
    "poses that are none": ("named_states", [1], "has no attribute 'items'"),
    "motors with limits of another size": (
        "actuators",
        LIMITED,
        "limits of 1 actuators must be those of 1 motors; got 2",
    ),
    "motors without ratios": ("actuators", {"names": ["m"]}, "'G' is missing"),
    "a pair of three": ("disabled_pairs", [["a", "b", "c"]], "too many values to unpack"),
    "a proof of nothing": ("proof", {}, "'pose_error' is missing"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_a_file_that_is_no_arm_is_refused_in_one_line(case: str, rover: Arm, tmp_path: Path) -> None:
    key, value, error = REFUSED[case]
    path = bake(rover, tmp_path)
    path.write_text(changed(path, key, value))
    with pytest.raises(DescriptionError) as caught:
        load_arm(path)
    message = str(caught.value)
    assert message.startswith(f"{path}: an unusable baked arm (")
    assert error in message
    assert message.endswith("; bake it again from the description: twistarm bake ARM FILE --force")


@pytest.mark.parametrize(
    ("text", "error"),
    [
        ("", "not a baked arm: Expecting value"),
        ("[]", "not a baked arm: it does not say 'format': 'twistarm arm'"),
        ('{"name": "package"}', "not a baked arm: it does not say 'format': 'twistarm arm'"),
        ("[" * 100_000, "not a baked arm: "),
        ("\x00\xff", "not a baked arm: "),
        ('{"format": "twistarm arm", "version": 2}', "it is of version 2, and this twistarm reads version 1; bake it"),
        ('{"format": "twistarm arm"}', "it is of version None, and this twistarm reads version 1; bake it"),
        ('{"format": "twistarm arm", "version": 1}', "edited or damaged since it was baked"),
        ('{"format": "twistarm arm", "version": 1, "reach": NaN}', "not a baked arm: Out of range float values"),
        ('{"format": "twistarm arm", "version": 1, "reach": 1e999}', "not a baked arm: Out of range float values"),
        ('{"format": "twistarm arm", "version": 1, "reach": ' + "9" * 5000 + "}", "not a baked arm: "),
    ],
    ids=lambda text: text[:24],
)
def test_other_files_are_refused_in_one_line(text: str, error: str, tmp_path: Path) -> None:
    path = tmp_path / "arm.json"
    path.write_bytes(text.encode("latin-1"))
    with pytest.raises(DescriptionError) as caught:
        load_arm(path)
    assert error in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_file_of_any_size_is_not_read(tmp_path: Path) -> None:
    path = tmp_path / "arm.json"
    with path.open("wb") as file:
        file.truncate(MAX_BYTES + 1)
    with pytest.raises(DescriptionError, match="it has 10,000,001 bytes; at most 10,000,000 are read"):
        load_arm(path)


def test_a_damaged_file_is_never_another_arm(everything: Arm, tmp_path: Path) -> None:
    """200 files with one bit turned: refused in one line, but where white space became another; 50 cut off."""
    path = bake(everything, tmp_path)
    data, arm = path.read_bytes(), load_arm(path)
    rng = np.random.default_rng(zlib.crc32(b"bake"))
    refused = 0
    for at in rng.integers(len(data), size=200).tolist():
        path.write_bytes(data[:at] + bytes([data[at] ^ 1 << int(rng.integers(8))]) + data[at + 1 :])
        try:
            assert_same(load_arm(path), arm)
        except DescriptionError:
            refused += 1
    assert refused > 150
    for end in rng.integers(len(data) - 2, size=50).tolist():
        path.write_bytes(data[:end])
        with pytest.raises(DescriptionError):
            load_arm(path)


def test_no_file_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(DescriptionError, match="no such file"):
        load_arm(tmp_path / "arm.json")


def test_where_it_may_be_written(rover: Arm, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"a baked arm is named \*\.json; got .*arm\.txt"):
        rover.bake(tmp_path / "arm.txt")
    with pytest.raises(InputError, match="does not exist; create it first"):
        rover.bake(tmp_path / "none" / "arm.json")
    description = write(tmp_path, "<robot/>")
    link = tmp_path / "link.json"
    link.symlink_to(description)
    with pytest.raises(InputError, match="a description stands there and would be lost"):
        rover.bake(link)
    assert description.read_text() == "<robot/>"


# -- the command -------------------------------------------------------------------------------------------------


def test_the_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    assert run(["bake", "rover_arm"]) == 0
    said = capsys.readouterr().out
    assert said == "rover_arm.json: rover_arm, 5 joints from base_link to tool0; next: twistarm info rover_arm.json\n"
    assert run(["bake", "rover_arm"]) == 2
    error = capsys.readouterr().err
    assert error == "error: rover_arm.json exists; --force replaces it, another name writes elsewhere\n"
    assert run(["bake", "rover_arm.json", "again.json", "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["file"] == "again.json"
    assert answer["digest"] == json.loads((tmp_path / "again.json").read_text("utf-8"))["digest"]
    assert (tmp_path / "again.json").read_bytes() == (tmp_path / "rover_arm.json").read_bytes()
    assert run(["bake", "rover_arm", "again.json", "--force"]) == 0
    capsys.readouterr()
    assert run(["fk", "rover_arm.json", "--json"]) == 0
    g = np.array(json.loads(capsys.readouterr().out)["matrix"])
    arm = load("rover_arm")
    assert np.abs(g - arm.pinocchio.link_pose(arm.pinocchio.q(arm.ready), arm.base, arm.tip)).max() < TOL


@pytest.mark.parametrize(
    ("arguments", "error"),
    [
        (["rover_arm", "arm.txt"], "error: a baked arm is named *.json; got arm.txt\n"),
        (["rover_arm", "none/arm.json"], "does not exist; create it first\n"),
        (["rover_arm.json"], "error: rover_arm.json: no such file; give a URDF or xacro file"),
    ],
)
def test_the_command_refuses_in_one_line(
    arguments: list[str],
    error: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run(["bake", *arguments]) == 2
    said = capsys.readouterr().err
    assert error in said
    assert said.count("\n") == 1
    assert not list(tmp_path.iterdir())
