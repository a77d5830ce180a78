"""An expansion reaches nothing else: no Python, no files outside, not the program's own xacro."""

from __future__ import annotations

import contextlib
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import xacro.substitution_args

from hostile.sandbox import XMLNS, Sandbox
from hostile.sandbox import place as place
from twistarm.description.expansion import confinement
from twistarm.description.expansion.expand import expand_xacro
from twistarm.description.expansion.module import own_xacro
from twistarm.description.packages import package_index
from twistarm.support.errors import DescriptionError, TwistarmError
from urdf_text import write
from xacro_text import as_xacro

BAD_YAML = {
    "aliases that double": "\n".join(
        ["a0: &a0 [ha]", *(f"a{i + 1}: &a{i + 1} [{', '.join([f'*a{i}'] * 10)}]" for i in range(12))]
    ),
    "merges that double": "\n".join(
        ["a0: &a0 {k: 1}", *(f"a{i + 1}: &a{i + 1} {{<<: [{', '.join([f'*a{i}'] * 10)}]}}" for i in range(12))]
    ),
    "itself": "a: &a [*a]",
    "an object": "!!python/object/apply:os.system ['touch @MARKER']",
    "an unknown tag": "a: !secret '@SECRET'",
    "an escape in a unit": "a: !degrees ().__class__.__base__.__subclasses__()",
    "no number in a unit": "a: !degrees left",
    "a number in base 60": "a: 1" + ":1" * 100_000,
    "lists without end": "a: [" + "1, " * 1_000_000 + "1]",
}


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


@contextlib.contextmanager
def in_a_thread(work: Callable[[], None]) -> Iterator[None]:
    """`work` again and again in another thread, which takes turns with this one as often as it can."""
    over, failures = threading.Event(), []

    def run() -> None:
        try:
            while not over.is_set():
                work()
        except Exception as error:
            failures.append(error)

    thread = threading.Thread(target=run)
    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-5)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()
        sys.setswitchinterval(interval)
    assert not failures


def with_its_own_names(folder: Path, name: str, size: float) -> Path:
    """A file whose text comes from an argument, a property and a macro, all named as in every other."""
    inside = (
        f'<xacro:arg name="side" default="{name}"/><xacro:property name="size" value="{size}"/>'
        f'<xacro:macro name="part" params="i"><link name="{name}_$(arg side)_${{i}}_${{size * 2}}"/></xacro:macro>'
    )
    calls = "".join(f'<xacro:part i="{i}"/>' for i in range(20))
    return write(folder, f'<robot name="{name}" {XMLNS}>{inside}{calls}</robot>', f"{name}.xacro")


def test_a_program_may_use_xacro_at_the_same_time(tmp_path: Path) -> None:
    ours = with_its_own_names(tmp_path, "ours", 1.0)
    theirs = with_its_own_names(tmp_path, "theirs", 3.0)
    theirs.write_text(theirs.read_text().replace("${i}", "${(lambda: i)()}"))
    alone = expand_xacro(ours, package_index(ours))
    plain = xacro.process_file(str(theirs), verbosity=0).toxml()

    def use_xacro() -> None:
        assert xacro.process_file(str(theirs), verbosity=0).toxml() == plain

    with in_a_thread(use_xacro):
        assert [expand_xacro(ours, package_index(ours)) for _ in range(40)] == [alone] * 40


def test_two_threads_expand_one_file_each(tmp_path: Path) -> None:
    one, other = with_its_own_names(tmp_path, "one", 1.0), with_its_own_names(tmp_path, "other", 3.0)
    alone, other_alone = (expand_xacro(path, package_index(path)) for path in (one, other))

    def expand_the_other() -> None:
        assert expand_xacro(other, package_index(other)) == other_alone

    with in_a_thread(expand_the_other):
        assert [expand_xacro(one, package_index(one)) for _ in range(40)] == [alone] * 40
