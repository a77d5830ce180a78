"""Files that once hung, crashed or fooled somebody, each with what comes of it now. One line to add another."""

from __future__ import annotations

from pathlib import Path

import pytest

from fuzz import oracle

HOSTILE = Path(__file__).parents[1] / "data" / "hostile"

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
    "utf_16_without_mark.urdf": (),
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
