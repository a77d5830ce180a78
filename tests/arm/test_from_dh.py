"""Denavit–Hartenberg tables against a product of four matrices, both ways, and from files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from twistarm import Arm, DhTable, InputError, arm_from_dh, arm_from_screws, crosscheck, joints, load_arm, to_dh
from twistarm.arm.loading.from_dh import dh_csv
from twistarm.description.document import noted_files
from twistarm.support.errors import DescriptionError

TOL = 1e-12
HALF = np.pi / 2
UR5 = [  # a, alpha, d, theta of the maker's table
    [0.0, HALF, 0.089159, 0.0],
    [-0.425, 0.0, 0.0, 0.0],
    [-0.39225, 0.0, 0.0, 0.0],
    [0.0, HALF, 0.10915, 0.0],
    [0.0, -HALF, 0.09465, 0.0],
    [0.0, 0.0, 0.0823, 0.0],
]


def about(axis: int, angle: float, way: float) -> np.ndarray:
    """A turn about an axis and a way along it."""
    c, s, i, j = np.cos(angle), np.sin(angle), (axis + 1) % 3, (axis + 2) % 3
    T = np.eye(4)
    T[i, i] = T[j, j] = c
    T[j, i], T[i, j], T[axis, 3] = s, -s, way
    return T


def by_product(table: DhTable, theta: np.ndarray) -> np.ndarray:
    """The forward kinematics as the textbooks write it."""
    g = table.base
    for (a, alpha, d, angle), kind, q in zip(table.rows, table.types, theta, strict=True):
        turn, way = (angle, d + q) if kind == "prismatic" else (angle + q, d)
        z, x = about(2, turn, way), about(0, alpha, a)
        g = g @ (z @ x if table.convention == "standard" else x @ z)
    return g @ table.tool


def require_same(arm: Arm, table: DhTable) -> None:
    for theta in arm.random_theta(1, 50):
        np.testing.assert_allclose(arm.fk(theta), by_product(table, theta), atol=TOL)


def random_table(rng: np.random.Generator, convention: str) -> DhTable:
    n = int(rng.integers(1, 8))
    rows = rng.uniform(-1, 1, (n, 4)) * [0.5, np.pi, 0.5, np.pi]
    rows[rng.random((n, 4)) < 0.3] = 0.0
    rows[rng.random(n) < 0.3, 1] = HALF
    types = tuple(rng.choice(["revolute", "revolute", "prismatic"], n))
    poses = (about(i, rng.uniform(-3, 3), 0.3) @ about(2, rng.uniform(-3, 3), 0.2) for i in (0, 1))
    return DhTable(rows, convention, None, types, *poses)


@pytest.mark.parametrize("convention", ["standard", "modified"])
def test_an_arm_moves_as_its_table_says(convention: str) -> None:
    rng = np.random.default_rng(0)
    for _ in range(8):
        table = random_table(rng, convention)
        require_same(arm_from_dh(table), table)
    arm = arm_from_dh(UR5, convention, name="ur5")
    require_same(arm, DhTable(np.array(UR5), convention))
    assert crosscheck(arm, 20).ok


UNITS = {
    "SI": "a,alpha,d,theta\n0.3,1.5707963267948966,0.1,0.7853981633974483",
    "mm and degrees": "a [mm], Alpha (deg), d (mm), theta_deg\n300, 90, 100, 45",
    "cm, inches and signs": "A [cm];α [°];D [in];θ [deg]\n30;90;3.937007874015748;45",
}


@pytest.mark.parametrize("text", UNITS.values(), ids=UNITS)
def test_the_columns_of_a_file_have_units(text: str, tmp_path: Path) -> None:
    (tmp_path / "arm.csv").write_text(text)
    require_same(
        arm_from_dh(tmp_path / "arm.csv", "modified"), DhTable(np.array([[0.3, HALF, 0.1, HALF / 2]]), "modified")
    )


def test_a_file_that_names_its_convention_is_an_arm(tmp_path: Path) -> None:
    """Limits in the unit of each joint, and the flange of a data sheet as a fixed row."""
    path = tmp_path / "scara.csv"
    path.write_text(
        "joint,type,convention,a [mm],d [mm],theta [deg],"
        "lower [deg],upper [deg],lower [mm],upper [mm],velocity [deg/s]\n"
        "stand,fixed,standard,0,500,30,,,,,\n"
        "shoulder,revolute,standard,300,0,0,-90,90,,,180\n"
        "lift,prismatic,,0,100,0,,,0,200,\n"
        "flange,fixed,,0,107,45,,,,,\n"
    )
    with noted_files() as watched:
        arm = load_arm(path)
    assert watched == {path}
    rows = np.array([[0.3, 0, 0, 0], [0, 0, 0.1, 0]])
    ends = about(2, np.pi / 6, 0.5), about(2, np.pi / 4, 0.107)
    require_same(arm, DhTable(rows, "standard", None, ("revolute", "prismatic"), *ends))
    assert (arm.name, arm.joint_names) == ("scara", ("shoulder", "lift"))
    np.testing.assert_allclose([arm.limits.lower, arm.limits.upper], [[-HALF, 0], [HALF, 0.2]])
    assert arm.limits.velocity.tolist() == [pytest.approx(np.pi), np.inf]
    with pytest.raises(InputError, match="the conventions 'modified', 'standard'"):
        arm_from_dh(path, "modified")
    path.write_text("a\n1\n")
    with pytest.raises(DescriptionError, match=r"scara\.csv: .*say the convention, standard .* or modified"):
        load_arm(path)


@pytest.mark.parametrize("to", ["standard", "modified"])
@pytest.mark.parametrize("convention", ["standard", "modified"])
def test_an_arm_gives_a_table_that_moves_alike(convention: str, to: str, tmp_path: Path) -> None:
    """Its file too, with base and tool as fixed rows."""
    rng = np.random.default_rng(1)
    for _ in range(8):
        table = random_table(rng, convention)
        arm = arm_from_dh(table)
        again = to_dh(arm, to)
        assert again.residual < TOL
        require_same(arm, again)
        (tmp_path / "table.csv").write_text(dh_csv(again))
        theta = arm.random_theta(1, 5)
        np.testing.assert_allclose(load_arm(tmp_path / "table.csv").fk(theta), arm.fk(theta), atol=TOL)


@pytest.mark.parametrize("convention", ["standard", "modified"])
@pytest.mark.parametrize("name", ["rover_arm", "rover_arm_6dof", "ur5", "panda"])
def test_real_arms_have_a_table(name: str, convention: str, tmp_path: Path) -> None:
    """Its file, which has base and tool as fixed rows, loads as the same arm."""
    arm = load_arm(name)
    table = to_dh(arm, convention)
    (tmp_path / "table.csv").write_text(dh_csv(table))
    again = load_arm(tmp_path / "table.csv")
    np.testing.assert_allclose(again.fk(arm.random_theta(1, 20)), arm.fk(arm.random_theta(1, 20)), atol=TOL)
    for limit in ("lower", "upper", "velocity", "effort"):
        np.testing.assert_array_equal(getattr(again.limits, limit), getattr(arm.limits, limit))
    theta = arm.random_theta(1, 20)
    difference = max(np.abs(by_product(table, q) - arm.fk(q)).max() for q in theta)
    assert difference <= max(TOL, 2 * table.residual)
    assert table.residual < 1e-9
    assert table.joints == arm.joint_names


def test_the_makers_table_of_the_ur5_comes_back() -> None:
    """Up to signs of a and α, which turn with the common normals."""
    table = to_dh(arm_from_dh(UR5, "standard"))
    np.testing.assert_allclose(np.abs(table.rows[:, 0]), np.abs(UR5)[:, 0], atol=TOL)
    np.testing.assert_allclose(np.abs(np.sin(table.rows[:, 1])), np.abs(np.sin(UR5))[:, 1], atol=TOL)


def test_nearly_parallel_axes_tell_their_residual() -> None:
    tilted = [np.sin(3e-8), 0.0, np.cos(3e-8)]
    screws = np.hstack([joints.revolute([0, 0, 1], [0, 0, 0]), joints.revolute(tilted, [0.5, 0, 0])])
    arm = arm_from_screws(screws, about(0, 0.0, 1.0))
    table = to_dh(arm)
    assert 1e-9 < table.residual < 1e-7
    exact = to_dh(arm, parallel=1e-9)  # the common normal is far away
    assert exact.residual < 1e-9
    assert np.abs(exact.rows).max() > 1e5
    for wrong in (0.0, -1e-9, 0.2, np.nan):
        with pytest.raises(InputError, match="parallel"):
            to_dh(arm, parallel=wrong)


@pytest.mark.parametrize(
    "screws", [joints.helical([0, 0, 1], [0, 0, 0], 0.1), 2.0 * joints.revolute([0, 0, 1], [0, 0, 0])]
)
def test_screws_without_a_table_are_refused(screws: np.ndarray) -> None:
    with pytest.raises(InputError, match="pitch or a rate"):
        to_dh(arm_from_screws(screws, np.eye(4)))


def test_an_arm_toml_may_name_the_table(tmp_path: Path) -> None:
    (tmp_path / "table.csv").write_text(
        "joint,type,convention,a_mm,alpha,d,theta\n,fixed,modified,0,0,0.5,0.3\nwaist,,,,,0.2,\nbend,,,300,1.5708,,0.1\n"
    )
    path = tmp_path / "arm.toml"
    path.write_text(
        'name = "bent"\nsource = "table.csv"\n[tool]\nname = "pen"\nxyz = [0.1, 0, 0]\n'
        "[limits.bend]\nlower = -1\nupper = 2\n"
    )
    arm = load_arm(path)
    rows = np.array([[0, 0, 0.2, 0], [0.3, 1.5708, 0, 0.1]])
    table = DhTable(rows, "modified", base=about(2, 0.3, 0.5), tool=about(0, 0.0, 0.1))
    require_same(arm, table)
    assert (arm.name, arm.base, arm.tip, arm.joint_names) == ("bent", "base", "pen", ("waist", "bend"))
    assert (arm.limits.lower[1], arm.limits.upper[1]) == (-1, 2)


@pytest.mark.parametrize(
    ("text", "culprit"),
    [
        ("", "rows of a, alpha, d, theta"),
        ("a", "rows of a, alpha, d, theta"),
        ("a,alpha,d,phi,convention\n1,2,3,4,standard", "'phi'"),
        ("a,alpha,convention\n1", "line 2"),
        ("a,alpha,convention\n1,b,standard", "row 1: alpha"),
        ("a,joint,convention\n1,x,standard\n2,x,standard", "joints"),
        ("alpha,convention\n90,standard", "alpha_deg"),
        ("a,upper,convention\n1,170,standard", "upper_deg"),
        ("a,a_mm,convention\n1,1000,standard", "row 1"),
        ("type,lower_deg,convention\nprismatic,3,standard", "row 1: lower_deg"),
        ("type,convention\nball,standard", "'ball'"),
        ("a,type,convention\n1,,standard\n,fixed,\n1,,", "fixed"),
        ("a,convention\n1,standard\n1,modified", "'modified', 'standard'"),
        ("a,lower,upper,convention\n1,2,1,standard", "swapped"),
        ("a\n1", "convention"),
    ],
)
def test_an_unusable_table_names_the_culprit(text: str, culprit: str, tmp_path: Path) -> None:
    (tmp_path / "table.csv").write_text(text)
    for read, errors in ((load_arm, DescriptionError), (arm_from_dh, (InputError, DescriptionError))):
        with pytest.raises(errors) as caught:
            read(tmp_path / "table.csv")
        assert culprit in str(caught.value)


def test_a_table_takes_no_xacro_arguments(tmp_path: Path) -> None:
    (tmp_path / "table.csv").write_text("a,convention\n1,standard")
    with pytest.raises(DescriptionError, match="a DH table and takes no xacro arguments .side."):
        load_arm(tmp_path / "table.csv", xacro_args={"side": "left"})


def test_a_table_is_of_one_convention() -> None:
    for table, convention in ((UR5, None), (DhTable(np.array(UR5), "standard"), "modified")):
        with pytest.raises(InputError, match="convention"):
            arm_from_dh(table, convention)
