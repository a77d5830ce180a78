"""Descriptions that ask for much work: what twistarm must load or refuse within seconds and megabytes."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from .expansions import COMMENTS, LOOKUPS
from .sandbox import XMLNS
from .texts import (
    ARM,
    COLLISION,
    LOADS,
    MESH,
    PROPERTY,
    Case,
    Text,
    chain,
    hanging,
    links,
    mimics,
    named,
    part,
    times,
    urdf,
    xacro,
)

ATTRIBUTE = 'a{0}="" '
NAMESPACE = 'xmlns:a{0}="b" '


def many_attributes(element: str) -> Text:
    """`element` with 100,000 attributes in the place of @."""
    return lambda: element.replace("@", times(100_000, ATTRIBUTE))


LARGE = {
    **{
        f"100,000 attributes on a {where} of a URDF": urdf(many_attributes(element.format(i="x")))
        for where, element in {
            "link": '<link name="x" @/><joint name="x" type="fixed"><parent link="tool"/><child link="x"/></joint>',
            "joint": '<link name="x"/><joint name="x" type="fixed" @><parent link="tool"/><child link="x"/></joint>',
            "limit": '<link name="x"/><joint name="x" type="revolute"><parent link="tool"/><child link="x"/>'
            '<axis xyz="0 0 1"/><limit lower="-1" upper="1" velocity="1" effort="1" @/></joint>',
            "shape": '<link name="x"><visual><geometry><box size="1 1 1" @/></geometry></visual></link>'
            '<joint name="x" type="fixed"><parent link="tool"/><child link="x"/></joint>',
        }.items()
    },
    "100,000 attributes on the robot": Case(
        {"arm.urdf": lambda: f'<robot name="r" {times(100_000, ATTRIBUTE)}>{ARM}</robot>'}
    ),
    "100,000 attributes on an element of a xacro file": xacro(many_attributes("<a @/>")),
    "10,000 namespaces": Case(
        {"arm.xacro": lambda: f'<robot name="r" {XMLNS} {times(10_000, NAMESPACE)}>{ARM}</robot>'}
    ),
    "an attribute of 49 MB": urdf(lambda: f'<x a="{"b" * 49_000_000}"/>', "at most 20,000,000 are read"),
    "a name of 9 MB": urdf(
        lambda: (
            f'<link name="{"b" * 9_000_000}"/><joint name="x" type="fixed"><parent link="tool"/>'
            f'<child link="{"b" * 9_000_000}"/></joint>'
        ),
        "name",
    ),
    "an origin of 5,000,000 digits": urdf(lambda: part(more=f'<origin xyz="0.{"1" * 5_000_000} 0 0"/>'), "no number"),
    "1,000,000 elements in one link": urdf(
        lambda: part("<x/>" * 1_000_000), "more than 250,000 elements and attributes"
    ),
    "5,000 collisions on a link": urdf(lambda: part(times(5_000, COLLISION))),
    "9,000 meshes of 9,000 packages": urdf(
        lambda: (
            f'<link name="x">{times(9_000, MESH.format("package://p{0}/m.stl"))}</link>'
            '<joint name="x" type="fixed"><parent link="tool"/><child link="x"/></joint>'
        )
    ),
}

TREES = {
    "20,000 links side by side": urdf(lambda: links(20_000, lambda i: "tool"), "<link>|elements and attributes"),
    "2,000 links in a chain": urdf(lambda: links(2_000, chain), "chain of more than"),
    "3,900 links in chains of 50": urdf(lambda: links(3_900, hanging(50))),
    "3,000 joints between nothing": urdf(
        lambda: times(3_000, '<joint name="k{0}" type="fixed"><parent link="x{0}"/><child link="y{0}"/></joint>'),
        "not defined",
    ),
    "3,000 joints with words unread": urdf(
        lambda: links(3_000, lambda i: "tool", more='<orgin xyz="0 0 1"/><origin xzy="1 1 1"/>')
    ),
    "a circle of 3,000 links": urdf(
        lambda: "".join(
            f'<link name="l{i}"/><joint name="k{i}" type="fixed"><parent link="l{(i + 1) % 3_000}"/>'
            f'<child link="l{i}"/></joint>'
            for i in range(3_000)
        ),
        "cycle",
    ),
    "100 joints in a chain": urdf(lambda: links(98, chain, "continuous", '<origin xyz="0.1 0 0"/>')),
    "a chain of 145 mimics": urdf(lambda: mimics(143, lambda i: f"k{i - 1}" if i else "j2")),
    "240 joints in a chain": urdf(lambda: links(238, chain, "continuous", '<origin xyz="0.1 0 0"/>'), "moving joints"),
    "240 mimics of one joint": urdf(lambda: mimics(240, lambda i: "j2"), "moving joints"),
    "100 mimics of one joint": urdf(lambda: mimics(100, lambda i: "j2")),
    "100 mimics in a circle": urdf(lambda: mimics(100, lambda i: f"k{(i + 1) % 100}"), "circle"),
}

SRDF = '<robot name="r">{}</robot>'


def beside(inside: Callable[[], str], arm: Callable[[], str] = lambda: "", refusal: str = LOADS) -> Case:
    """An arm with an SRDF beside it."""
    return urdf(arm, refusal, arm_srdf=lambda: SRDF.format(inside()))


def toml(text: Callable[[], str], refusal: str = LOADS, arm: Callable[[], str] = lambda: "", **files: Text) -> Case:
    """An arm with an arm.toml."""
    head = 'source = "arm.urdf"\n'
    return Case(
        {
            "arm.toml": lambda: head + text(),
            "arm.urdf": lambda: f'<robot name="r">{ARM}{arm()}</robot>',
            **named(files),
        },
        refusal,
    )


FLAT_100 = '<disable_collisions link1="l{0}" link2="tool"/>'

BESIDE = {
    "10,000 pairs in an SRDF": beside(
        lambda: "".join(f'<disable_collisions link1="l{i}" link2="l{j}"/>' for i in range(150) for j in range(i))[
            :900_000
        ].rpartition("<")[0],
        lambda: links(150, lambda i: "tool"),
    ),
    "200 groups in each other": beside(
        lambda: "".join(
            f'<group name="g{i}">'
            + times(200, '<group name="g{0}"/>').replace(f'<group name="g{i}"/>', "")
            + "</group>"
            for i in range(200)
        )
    ),
    "200 chains of 900 links": beside(
        lambda: "".join(
            f'<group name="g{i}"><chain base_link="base" tip_link="l{899 - i}"/></group>' for i in range(200)
        ),
        lambda: links(900, chain),
    ),
    "an SRDF that is a xacro file of comments": urdf(
        lambda: "", arm_srdf=lambda: f'<robot name="r" {XMLNS}>{"<!--c-->" * 100_000}{PROPERTY}</robot>'
    ),
    "200 SRDFs of 900 kB": Case(
        {
            "arm.urdf": lambda: f'<robot name="r">{ARM}</robot>',
            **{f"s{i}.srdf": lambda: SRDF.format("<a/>" * 220_000) for i in range(200)},
        }
    ),
    "1,000 poses in an arm.toml": toml(lambda: times(1_000, "[poses.p{0}]\nj1 = 0.1\nj2 = 0.1\n")),
    "limits of 3,000 joints in YAML": toml(
        lambda: 'joint_limits = "joint_limits.yaml"\n',
        arm=lambda: links(3_000, lambda i: "tool"),
        joint_limits_yaml=lambda: (
            "joint_limits:\n  j1:\n    max_velocity: 1\n" + times(3_000, "  k{0}:\n    max_velocity: 1\n")
        ),
    ),
}


def manifests(count: int, size: int, late: bool = False) -> Callable[[Path], None]:
    """`count` folders with a package.xml of `size` bytes each, the name at its begin or its end."""

    def make(folder: Path) -> None:
        filler = f"<!--{'c' * size}-->"
        for i in range(count):
            one = folder / f"p{i}"
            one.mkdir()
            name = f"<name>p{i}_of_others</name>"
            (one / "package.xml").write_text(f"<package>{filler + name if late else name + filler}</package>")

    return make


def loops(folder: Path) -> None:
    """Links that lead to themselves, to each other and to what they stand in."""
    deep = folder / "deep"
    deep.mkdir()
    (folder / "self").symlink_to("self")
    (folder / "one").symlink_to("other")
    (folder / "other").symlink_to("one")
    for i in range(12):
        (deep / f"parent{i}").symlink_to(folder)
        (deep / f"here{i}").symlink_to(deep)


def wide(count: int) -> Callable[[Path], None]:
    """`count` folders, each with as many more."""

    def make(folder: Path) -> None:
        for i in range(count):
            for j in range(20):
                (folder / "wide" / f"w{i}" / f"x{j}").mkdir(parents=True)

    return make


NOWHERE = '<link name="x"><visual><geometry><mesh filename="package://nowhere/m.stl"/></geometry></visual></link>' + (
    '<joint name="x" type="fixed"><parent link="tool"/><child link="x"/></joint>'
)


def searching(make: Callable[[Path], None], *options: str) -> Case:
    """An arm that asks for a package which is nowhere."""
    return Case({"arm.urdf": lambda: f'<robot name="r">{ARM}{NOWHERE}</robot>'}, LOADS, options, make)


FOLDERS = {
    "200 manifests of 1 MB, the name at the end": searching(manifests(200, 990_000, late=True)),
    "links in circles": searching(loops, "--package-dir", "."),
    "a folder of 40,000": searching(wide(2_000), "--package-dir", "."),
    "the whole disk": searching(lambda folder: None, "--package-dir", "/"),
    "a loop as folder of packages": Case(
        {"arm.urdf": lambda: f'<robot name="r">{ARM}</robot>'}, "loop|usable", ("--package-dir", "self"), loops
    ),
}

CASES: dict[str, Case] = {**COMMENTS, **LOOKUPS, **LARGE, **TREES, **BESIDE, **FOLDERS}
