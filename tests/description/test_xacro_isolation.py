"""An expansion reaches nothing else: no Python, no files outside, not the program's own xacro."""

from __future__ import annotations

import shutil
import sys
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path

import pytest
import xacro

from hostile.sandbox import XMLNS, Sandbox
from hostile.sandbox import place as place
from twistarm.description.expansion import expand
from twistarm.description.expansion.expand import expand_xacro
from twistarm.description.packages import package_index
from twistarm.support.errors import DescriptionError, TwistarmError
from twistarm.support.worker_process import Shared
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
    another = Path(shutil.copytree(Path(xacro.__file__).parent, tmp_path / "other" / "xacro"))
    (another / "__init__.py").write_text((another / "__init__.py").read_text().replace("re_macro_arg", "re_macro"))
    monkeypatch.syspath_prepend(tmp_path / "other")
    monkeypatch.setattr(expand, "shared", Shared())
    path = write(tmp_path, as_xacro(""), "arm.xacro")
    with pytest.raises(TwistarmError, match=r"has no re_macro_arg and cannot be confined; pip install xacro==2.1.1"):
        expand_xacro(path, package_index(path))


def test_a_second_expansion_finds_nothing_of_the_first(place: Sandbox) -> None:
    """Properties, macros, arguments, tags of YAML and what failed stay with their file."""
    good = "<link name=\"${pi} ${xacro.load_yaml('a.yaml').a}\"/>"
    first = place.expand(good, {"a.yaml": "a: !degrees 180"})
    for inside in (
        '<xacro:property name="pi" value="3"/><xacro:macro name="m"/>',
        "${nothing}",
        "$(arg x)",
        "<xacro:m/>",
    ):
        place.write({"arm.xacro": f'<robot name="r" {XMLNS}><xacro:arg name="y" default="1"/>{inside}</robot>'})
        with suppress(DescriptionError):
            place.expand_file()
        assert place.expand(good) == first
    assert "unknown macro name: xacro:m" in place.refuse("<xacro:m/>")
    assert "argument y" in place.refuse("<a>$(arg y)</a>")


def test_it_starts_where_the_working_folder_has_gone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(expand, "shared", Shared())
    gone = tmp_path / "gone"
    gone.mkdir()
    monkeypatch.chdir(gone)
    gone.rmdir()
    path = write(tmp_path, as_xacro('<a b="$(cwd)"/>'), "arm.xacro")
    assert '<a b="package://.cwd"/>' in expand_xacro(path, package_index(path)).text
    path = write(tmp_path, as_xacro('<xacro:include filename="$(cwd)/part.xacro"/>'), "arm.xacro")
    with pytest.raises(DescriptionError, match=r"the working folder has gone: \$\(cwd\); correct the path"):
        expand_xacro(path, package_index(path))


def test_nothing_is_printed(place: Sandbox, capfd: pytest.CaptureFixture[str]) -> None:
    place.expand("<link name=\"${xacro.warning('loud')}\"/><xacro:property name='pi' value='3'/>")
    assert capfd.readouterr() == ("", "")


def with_its_own_names(folder: Path, name: str, size: float) -> Path:
    """A file whose text comes from an argument, a property and a macro, all named as in every other."""
    inside = (
        f'<xacro:arg name="side" default="{name}"/><xacro:property name="size" value="{size}"/>'
        f'<xacro:macro name="part" params="i"><link name="{name}_$(arg side)_${{i}}_${{size * 2}}"/></xacro:macro>'
    )
    calls = "".join(f'<xacro:part i="{i}"/>' for i in range(20))
    return write(folder, f'<robot name="{name}" {XMLNS}>{inside}{calls}</robot>', f"{name}.xacro")


def test_threads_expand_one_file_each(tmp_path: Path) -> None:
    """One process expands them, one after the other."""
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
