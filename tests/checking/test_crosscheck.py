"""The cross-check: it agrees where arms are right, finds what is wrong, and says what it did not compare."""

from __future__ import annotations

import builtins
import dataclasses
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import twistarm
from test_loading import REAL
from twistarm import arm_from_screws, assert_arm, crosscheck, load_arm
from twistarm.support.errors import ComparisonError, InputError, MissingExtraError
from urdf_text import joint, robot, two_joints, write

PINOCCHIO_TOL, YOURDFPY_TOL = 1e-12, 1e-9  # What every arm of the catalogue must keep to.


def test_catalogue_arms_agree_in_every_engine(catalogue_arm: twistarm.Arm) -> None:
    result = crosscheck(catalogue_arm, samples=100).require()
    assert result.worst("pinocchio") <= PINOCCHIO_TOL
    assert 0 < result.worst("yourdfpy") <= YOURDFPY_TOL


@pytest.mark.parametrize("name", REAL)
def test_real_arms_agree_in_every_engine(name: str, models: Path) -> None:
    file, arguments, tip, _ = REAL[name]
    result = crosscheck(load_arm(models / file, xacro_args=arguments, tip=tip), samples=100).require()
    assert result.worst("pinocchio") <= PINOCCHIO_TOL
    assert result.worst("yourdfpy") <= YOURDFPY_TOL


def test_a_wrong_screw_is_found_with_the_quantity_and_the_posture() -> None:
    arm = load_arm("scara")
    wrong = dataclasses.replace(arm, screws=arm.screws + 1e-6 * np.eye(6)[:, :1])
    result = crosscheck(wrong, samples=20)
    assert not result.ok
    failed = {row.quantity for row in result.comparisons if not row.ok}
    assert {"pose", "spatial Jacobian"} <= failed
    with pytest.raises(ComparisonError, match="pose: poe and pinocchio"):
        result.require()


def test_what_an_engine_cannot_do_is_not_compared(tmp_path: Path) -> None:
    parts = joint("a", "base_link", "upper"), joint("b", "upper", "tool0"), joint("p", "upper", "pad", kind="planar")
    arm = load_arm(write(tmp_path, robot(*parts, links=("base_link", "upper", "tool0", "pad"))), tip="tool0")
    rows = [row for row in crosscheck(arm, 10).comparisons if "yourdfpy" in row.engines]
    assert ["'p'" in row.not_compared for row in rows] == [True]
    follower = joint("m", "upper", "pad", inside='<mimic joint="n"/>')
    master = joint("n", "upper", "rod", inside='<mimic joint="a"/>')
    arm = load_arm(
        write(tmp_path, robot(*parts[:2], follower, master, links=("base_link", "upper", "tool0", "pad", "rod"))),
        tip="tool0",
    )
    rows = [row for row in crosscheck(arm, 10).comparisons if "yourdfpy" in row.engines]
    assert ["'m'" in row.not_compared for row in rows] == [True]


@pytest.mark.parametrize(("given", "quantity"), [('xyz="0 0 0.7"', "all links"), ('lower="-2"', "limits")])
def test_what_our_own_reading_loses_is_found(given: str, quantity: str, tmp_path: Path) -> None:
    """As if our reading had passed over an attribute that stands in the text."""
    arm = load_arm(write(tmp_path, two_joints()))
    assert crosscheck(arm, 10).ok
    tag = "<origin " if "xyz" in given else "<limit "
    name = given.partition("=")[0]
    text = re.sub(rf'({tag}[^>]*?){name}="[^"]*"', rf"\1{given}", arm.description.text, count=1)
    assert text != arm.description.text
    result = crosscheck(dataclasses.replace(arm, description=dataclasses.replace(arm.description, text=text)), 10)
    assert {row.quantity for row in result.comparisons if not row.ok and "as written" in row.engines[1]} == {quantity}


def test_what_pinocchio_does_not_read_as_it_is_written_is_not_compared(tmp_path: Path) -> None:
    text = two_joints(inside='<limit lower="-1" upper="1" velocity="1" effort="-1"/>')
    (why,) = (row.not_compared for row in crosscheck(load_arm(write(tmp_path, text)), 10).comparisons
              if "as written" in row.engines[1])  # fmt: skip
    assert why.startswith("Pinocchio does not read the unchanged file: ")


def test_a_hundred_followers_of_one_joint_agree_and_take_no_minutes(tmp_path: Path) -> None:
    names = [f"l{i}" for i in range(101)]
    mimic = '<axis xyz="0 1 0"/><mimic joint="a" multiplier="1"/>'
    joints = [joint(f"k{i}", names[i], names[i + 1], xyz="0.1 0 0", inside=mimic) for i in range(100)]
    text = robot(joint("a", "base", "upper"), joint("b", "upper", "l0"), *joints, links=("base", "upper", *names))
    result = crosscheck(load_arm(write(tmp_path, text)), samples=20).require()
    assert "103 links" in result.left_out["yourdfpy"]


def test_an_arm_from_screws_is_compared_with_the_core_and_differences() -> None:
    scara = load_arm("scara")
    result = crosscheck(arm_from_screws(scara.screws, scara.home), 20).require()
    rows = {row.quantity for row in result.comparisons if not row.not_compared and "core" not in row.engines}
    assert rows == {"J^s = Ad J^b", "body Jacobian"}
    assert set(result.left_out) == {"pinocchio", "yourdfpy"}


def test_without_yourdfpy_the_command_that_installs_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    arm = load_arm(write(tmp_path, two_joints()))
    real = builtins.__import__

    def blocked(name: str, *rest: Any, **more: Any) -> Any:
        if name == "yourdfpy":
            raise ImportError(name)
        return real(name, *rest, **more)

    monkeypatch.setattr(builtins, "__import__", blocked)
    rows = [row for row in crosscheck(arm, 5).comparisons if "yourdfpy" in row.engines]
    assert "pip install 'twistarm[check]'" in rows[0].not_compared
    assert list(crosscheck(arm, 5).left_out) == ["yourdfpy"]
    with pytest.raises(MissingExtraError, match="needs yourdfpy, which is not installed"):
        assert_arm(tmp_path / "arm.urdf")


def test_progress_and_samples(rover: twistarm.Arm) -> None:
    steps: list[float] = []
    crosscheck(rover, 5, progress=steps.append)
    assert steps == pytest.approx([k / 5 for k in range(1, 6)])
    with pytest.raises(InputError, match="rng must be a seed"):
        crosscheck(rover, 5, rng=-1)
    with pytest.raises(InputError, match="samples must be a whole number, at least 1"):
        crosscheck(rover, 0)
