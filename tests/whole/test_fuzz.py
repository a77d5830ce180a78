"""Mutants of real descriptions, and files that once hung, crashed or fooled somebody: refused in one line, or right."""

from __future__ import annotations

from pathlib import Path

import pytest

from fuzz import oracle
from fuzz.runner import campaign
from fuzz.sources import Source, catalogue_sources, own_sources, real_sources, seed_sources
from twistarm import load_arm
from urdf_text import two_joints, write

HOSTILE = Path(__file__).parents[1] / "data" / "hostile"


@pytest.mark.parametrize("count", [40, pytest.param(3_000, marks=pytest.mark.slow)])
def test_mutants_of_what_is_at_hand(count: int, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    run([*seed_sources(), *own_sources(), *(catalogue_sources() if count > 1000 else ())], count, tmp_path, capfd)


@pytest.mark.slow
def test_mutants_of_real_models(models: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    run(real_sources(models), 1_000, tmp_path, capfd)


def run(sources: list[Source], count: int, folder: Path, capfd: pytest.CaptureFixture[str]) -> None:
    outcomes, failed = campaign(sources, count, folder, lambda: "".join(capfd.readouterr()))
    assert not failed, "\n".join(failed)
    assert outcomes["loaded"] > count / 10, "mutants that nobody can load prove little"


# -- the fuzzer itself -------------------------------------------------------------------------------------------------


def judged_as(monkeypatch: pytest.MonkeyPatch, path: Path, load) -> dict:
    monkeypatch.setattr(oracle, "load_arm", load)
    return oracle.judged(path, {}, {})


def test_the_oracle_sees_a_wrong_pose(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path, other = write(tmp_path, two_joints()), write(tmp_path, two_joints(xyz="0 0 0.50001"), "other.urdf")
    assert judged_as(monkeypatch, path, load_arm)["problems"] == []
    assert "fk differs by 1e-05" in judged_as(monkeypatch, path, lambda _: load_arm(other))["problems"][0]


def test_the_oracle_sees_wrong_limits(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write(tmp_path, two_joints())
    verdict = judged_as(monkeypatch, path, lambda name: load_arm(name, limits={"upper": 0.9}))
    assert "limits of a: [-1.0, 0.9] instead of (-1.0, 1.0)" in verdict["problems"][0]


def test_the_oracle_sees_a_coordinate_that_is_lost(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write(tmp_path, two_joints())
    verdict = judged_as(monkeypatch, path, lambda name: load_arm(name, locked_joints={"b": 0.0}))
    assert "coordinates ['a'] instead of ['a', 'b']" in verdict["problems"][0]


def test_the_oracle_sees_a_wrong_mass(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = (HOSTILE / "inertia_without_an_entry.urdf").read_text("utf-8")
    path, other = (
        write(tmp_path, text),
        write(tmp_path, text.replace('mass value="2"', 'mass value="2.001"'), "other.urdf"),
    )
    assert "gravity torques do" in judged_as(monkeypatch, path, lambda _: load_arm(other))["problems"][0]


def test_the_oracle_sees_a_traceback(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(_: Path) -> None:
        raise KeyError("elbow")

    verdict = judged_as(monkeypatch, write(tmp_path, two_joints()), fail)
    assert verdict["outcome"] == "traceback"
    assert "KeyError: 'elbow'" in verdict["problems"][0]


@pytest.mark.parametrize(
    ("message", "flaw"),
    [("", "is empty"), ("x" * 2001, "has 2001"), ("one\ntwo", "control"), ("Traceback (most", "is Python's own")],
)
def test_the_oracle_sees_a_message_that_is_none(message: str, flaw: str) -> None:
    assert flaw in " ".join(oracle.flaws(message))


REFUSED = {
    "cut_in_a_character.urdf": "xml-malformed",
    "digits_of_another_script.urdf": "number-malformed",
    "includes_itself.xacro": "xacro-failed",
    "includes_zeros_without_end.xacro": "file-outside-packages",
    "loads_zeros_without_end.xacro": "file-outside-packages",
    "names_of_thousands.urdf": "name-unusable",
    "number_beyond_all_numbers.toml": "companion-unusable",
    "number_beyond_all_numbers.yaml": "companion-unusable",
    "source_of_itself.toml": "xml-malformed",
    "two_of_everything.urdf": "xml-malformed",
    "unit_after_a_limit.yaml": "companion-unusable",
    "utf_16_with_half_characters.urdf": "xml-malformed",
    "value_of_a_module.xacro": "xacro-expression-refused",
    "zero_bytes.urdf": "xml-malformed",
}
"""The code of the refusal."""

LOADED = {
    "arm_for_limits.urdf": (),
    "axis_that_is_nearly_z.urdf": (),
    "crumb_of_an_origin.urdf": (),
    "far_follower.urdf": ("outside-limits",),
    "far_from_the_world.urdf": (),
    "fast_follower.urdf": (),
    "fast_follower_with_limits.urdf": ("limits-adjusted",),
    "follows_itself_by_nothing.urdf": (),
    "half_a_character.urdf": (),
    "inertia_without_an_entry.urdf": ("inertial-unusable",),
    "latin_1.toml": (),
    "latin_1.xacro": (),
    "leaf_far_away.urdf": (),
    "limits_in_degrees_twice.urdf": (),
    "line_separator_in_a_name.urdf": ("rate-not-given", "rate-not-given"),
    "mass_of_infinity.urdf": ("inertial-unusable",),
    "mimic_on_a_fixed_joint.urdf": (),
    "number_of_fifty_digits.yaml": (),
    "slow_follower.urdf": (),
    "space_after_a_mass.urdf": (),
    "stuck_before_all_turns.urdf": ("limit-incomplete",),
    "stuck_beyond_all_turns.urdf": ("limit-incomplete",),
    "tab_in_an_origin.urdf": (),
    "tags_with_colons.urdf": (),
    "utf_16.xacro": (),
    "utf_16_with_umlauts.urdf": (),
    "utf_16_without_mark.urdf": (),
    "utf_32.urdf": (),
    "visual_at_infinity.urdf": ("bad-geometry",),
}
"""The codes of what was noticed."""


def judged(name: str) -> dict:
    """The oracle's verdict; a file of limits is given to a harmless arm."""
    path = HOSTILE / name
    arguments = {} if path.suffix == ".toml" else {"tip": "tool0"}
    if path.suffix == ".yaml":
        return oracle.judged(HOSTILE / "arm_for_limits.urdf", {**arguments, "limits": str(path)}, {})
    return oracle.judged(path, arguments, {})


@pytest.mark.parametrize("name", REFUSED)
def test_refused_in_one_line(name: str, capfd: pytest.CaptureFixture[str]) -> None:
    verdict = judged(name)
    assert (verdict["outcome"], verdict["problems"]) == ("refused", [])
    assert verdict["code"] == REFUSED[name]
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("name", LOADED)
def test_loaded_and_right_by_every_account(name: str, capfd: pytest.CaptureFixture[str]) -> None:
    verdict = judged(name)
    assert (verdict["outcome"], verdict["problems"]) == ("loaded", [])
    assert tuple(verdict["findings"]) == LOADED[name]
    assert capfd.readouterr() == ("", "")


def test_every_file_is_in_one_table() -> None:
    assert sorted([*REFUSED, *LOADED]) == sorted(path.name for path in HOSTILE.iterdir())
