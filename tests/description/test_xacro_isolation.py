"""An expansion reaches nothing else: no Python, no files outside, not the program's own xacro."""

from __future__ import annotations

import contextlib
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
import xacro.substitution_args

from hostile.sandbox import XMLNS, Sandbox
from hostile.sandbox import place as place
from twistarm.description.expansion import confinement
from twistarm.description.expansion.expand import expand_xacro, own_xacro
from twistarm.description.packages import package_index
from twistarm.support.errors import DescriptionError, TwistarmError
from urdf_text import write
from xacro_text import as_xacro

BAD_YAML = {
    "aliases that double": "\n".join(
        ["a0: &a0 [ha]", *(f"a{i + 1}: &a{i + 1} [{', '.join([f'*a{i}'] * 10)}]" for i in range(12))]
    ),
    "an object": "!!python/object/apply:os.system ['touch @MARKER']",
    "an escape in a unit": "a: !degrees ().__class__.__base__.__subclasses__()",
    "no number in a unit": "a: !degrees left",
    "lists without end": "a: [" + "1, " * 1_000_000 + "1]",
}
"""`test_yaml_reading` has what the loader itself refuses."""


@pytest.mark.parametrize("case", BAD_YAML)
def test_hostile_yaml_is_refused_in_one_line(case: str, place: Sandbox) -> None:
    message = place.refuse("<link name=\"${xacro.load_yaml('a.yaml')}\"/>", {"a.yaml": BAD_YAML[case]})
    assert "a.yaml" in message


BLOCKS = {
    "an element of a namespace": "${A['**block'].ownerDocument}",
    "a symbol of a namespace": "${A.parent.root}",
    "an element's class": "${A['**block'].__class__}",
}


@pytest.mark.parametrize("case", BLOCKS)
def test_documents_are_not_reached_through_blocks(case: str, place: Sandbox) -> None:
    part = f'<robot {XMLNS}><xacro:property name="block"><a/></xacro:property></robot>'
    inside = f'<xacro:include filename="part.xacro" ns="A"/><link name="{BLOCKS[case]}"/>'
    assert "arm.xacro" in place.refuse(inside, {"part.xacro": part})


def test_a_refusal_stands_through_optional_includes(place: Sandbox) -> None:
    part = f'<robot {XMLNS}><xacro:include filename="@SECRET" optional="true"/></robot>'
    message = place.refuse('<xacro:include filename="part.xacro" optional="true"/>', {"part.xacro": part})
    assert "part.xacro: " in message
    assert "lies outside" in message
    assert "<a/>" in place.expand('<xacro:include filename="absent.xacro" optional="true"/><a/>')


def test_a_xacro_that_cannot_be_confined_is_not_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(own_xacro(), "resolve_macro")
    path = write(tmp_path, as_xacro(""), "arm.xacro")
    with pytest.raises(TwistarmError, match=r"has no resolve_macro and cannot be confined; pip install xacro==2.1.1"):
        expand_xacro(path, package_index(path))


@pytest.mark.parametrize(
    "inside",
    [
        '<link name="${nothing}"/>',
        "<link name=\"${xacro.warning('loud')}\"/>",
        '<xacro:include filename="absent.xacro"/>',
        '<xacro:macro name="m"><xacro:m/></xacro:macro><xacro:m/>',
        "<link name=\"${'a' * 10**10}\"/>",
        '<xacro:property name="a" value="${xacro.load_yaml(\'a.yaml\')}"/><link name="${a}"/>',
        '<xacro:property name="pi" value="3"/><!-- seen --> <xacro:if value="1"><link name="a"/></xacro:if>',
    ],
)
def test_xacro_is_left_as_it_was(inside: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    import yaml

    def state() -> tuple[object, ...]:
        return (
            {name: value for name, value in vars(xacro).items() if not name.startswith("__")},
            {name: value for name, value in vars(xacro.substitution_args).items() if not name.startswith("__")},
            dict(xacro._global_symbols),
            dict(xacro._global_symbols["math"]),
            dict(xacro.substitution_args._eval_dict),
            dict(xacro.substitution_args_context),
            dict(yaml.SafeLoader.yaml_constructors),
            xacro._empty_text_node.parentNode,
            sys.stderr,
        )

    (tmp_path / "a.yaml").write_text("a: !degrees 3")
    before = state()
    path = write(tmp_path, as_xacro(inside), "arm.xacro")
    with contextlib.suppress(DescriptionError):
        expand_xacro(path, package_index(path))
    assert state() == before
    assert capfd.readouterr() == ("", "")


def test_nothing_of_the_programs_is_touched_while_a_file_is_expanded(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Other threads use xacro, and write to stderr, at the same time."""

    def seen() -> tuple[object, ...]:
        return dict(vars(xacro)), dict(vars(xacro.substitution_args)), sys.stderr, sys.stdout

    states = []

    def read(data: bytes) -> str:
        states.append(seen())
        return data.decode()

    before = seen()
    monkeypatch.setattr(confinement, "decoded", read)
    path = write(tmp_path, as_xacro("<link name=\"${xacro.warning('loud')}\"/>"), "arm.xacro")
    expand_xacro(path, package_index(path))
    assert states == [before]


def with_its_own_names(folder: Path, name: str, size: float) -> Path:
    """A file whose text comes from an argument, a property and a macro, all named as in every other."""
    inside = (
        f'<xacro:arg name="side" default="{name}"/><xacro:property name="size" value="{size}"/>'
        f'<xacro:macro name="part" params="i"><link name="{name}_$(arg side)_${{i}}_${{size * 2}}"/></xacro:macro>'
    )
    calls = "".join(f'<xacro:part i="{i}"/>' for i in range(20))
    return write(folder, f'<robot name="{name}" {XMLNS}>{inside}{calls}</robot>', f"{name}.xacro")


def test_threads_expand_one_file_each(tmp_path: Path) -> None:
    """xacro's state is global, so they take turns."""
    paths = with_its_own_names(tmp_path, "one", 1.0), with_its_own_names(tmp_path, "other", 3.0)
    alone = [expand_xacro(path, package_index(path)) for path in paths]
    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-5)
    try:
        with ThreadPoolExecutor(2) as pool:
            together = list(pool.map(lambda path: expand_xacro(path, package_index(path)), paths * 40))
    finally:
        sys.setswitchinterval(interval)
    assert together == alone * 40
