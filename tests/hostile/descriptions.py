"""Descriptions that ask for much work: what twistarm must load or refuse within seconds and megabytes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from .sandbox import XMLNS

LOADS = ""
"""Expected of a case that must load."""

ARM = (
    '<link name="base"/><link name="upper"/><link name="tool"/>'
    '<joint name="j1" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 0 1"/>'
    '<limit lower="-2" upper="2" velocity="1" effort="1"/></joint>'
    '<joint name="j2" type="revolute"><parent link="upper"/><child link="tool"/><origin xyz="0.3 0 0"/>'
    '<axis xyz="0 1 0"/><limit lower="-2" upper="2" velocity="1" effort="1"/></joint>'
)
"""Two joints, so that everything after the reading runs as well."""

LIMIT = '<limit lower="-2" upper="2" velocity="1" effort="1"/>'
MATERIAL = '<material name="m{0}"><color rgba="1 0 0 1"/></material>'
VISUAL = '<visual><geometry><box size="1 1 {0}"/></geometry></visual>'
COLLISION = '<collision><geometry><box size="1 1 {0}"/></geometry></collision>'
MESH = '<visual><geometry><mesh filename="{}"/></geometry></visual>'
INERTIAL = '<inertial><mass value="{}"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'

Text = Callable[[], str | bytes]


@dataclass(frozen=True)
class Case:
    """Files by their path, the first of which is loaded; `refusal`: words of the message, empty for what loads."""

    files: Mapping[str, Text]
    refusal: str = LOADS
    options: tuple[str, ...] = ()
    folders: Callable[[Path], None] | None = field(default=None, repr=False)

    def write(self, folder: Path) -> tuple[str, ...]:
        """Write the files; the arguments for `twistarm info`."""
        for name, text in self.files.items():
            path = folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            content = text()
            path.write_bytes(content if isinstance(content, bytes) else content.encode())
        if self.folders:
            self.folders(folder)
        return (next(iter(self.files)), *self.options)


def times(count: int, pattern: str) -> str:
    """`pattern` once for each number below `count`, which takes the place of {0}."""
    return "".join(pattern.replace("{0}", str(i)) for i in range(count))


def urdf(inside: Callable[[], str], refusal: str = LOADS, **files: Text) -> Case:
    """An arm with `inside` in its URDF."""
    return Case({"arm.urdf": lambda: f'<robot name="r">{ARM}{inside()}</robot>', **named(files)}, refusal)


def xacro(inside: Callable[[], str], refusal: str = LOADS, **files: Text) -> Case:
    """An arm with `inside` in its xacro file."""
    return Case({"arm.xacro": lambda: f'<robot name="r" {XMLNS}>{inside()}{ARM}</robot>', **named(files)}, refusal)


def named(files: Mapping[str, Text]) -> dict[str, Text]:
    """Keywords as names of files: `a_yaml` is a.yaml."""
    return {".".join(name.rsplit("_", 1)): text for name, text in files.items()}


def included(text: Text) -> Text:
    """A file to include that holds `text`."""
    return lambda: f"<robot {XMLNS}>{_str(text())}</robot>"


def _str(text: str | bytes) -> str:
    return text if isinstance(text, str) else text.decode()


def links(count: int, parent: Callable[[int], str], kind: str = "fixed", more: str = "") -> str:
    """`count` links, each on a joint of its own."""
    return "".join(
        f'<link name="l{i}"/><joint name="k{i}" type="{kind}"><parent link="{parent(i)}"/><child link="l{i}"/>{more}'
        "</joint>"
        for i in range(count)
    )


def chain(i: int) -> str:
    """The link before."""
    return f"l{i - 1}" if i else "tool"


def hanging(depth: int) -> Callable[[int], str]:
    """Chains of `depth` links on the tool."""
    return lambda i: f"l{i - 1}" if i % depth else "tool"


def mimics(count: int, master: Callable[[int], str]) -> str:
    """`count` followers one after the other, behind the tool."""
    return "".join(
        f'<link name="l{i}"/><joint name="k{i}" type="revolute"><parent link="{chain(i)}"/><child link="l{i}"/>'
        f'<origin xyz="0.1 0 0"/><axis xyz="0 1 0"/>{LIMIT}<mimic joint="{master(i)}" multiplier="1"/></joint>'
        for i in range(count)
    )


def nested_macros(depth: int, inside: str) -> str:
    """`depth` macros that call each other, `inside` in the innermost."""
    return (
        f'<xacro:macro name="m0">{inside}</xacro:macro>'
        + "".join(f'<xacro:macro name="m{i + 1}"><xacro:m{i}/></xacro:macro>' for i in range(depth))
        + f"<xacro:m{depth}/>"
    )


PROPERTY = '<xacro:property name="p" value="1"/>'
TOO_LARGE = "more work than any robot"
INCLUDE = '<xacro:include filename="a.xacro"/>'

COMMENTS = {
    "100,000 comments before a property": xacro(lambda: "<!--c-->" * 100_000 + PROPERTY),
    "190,000 comments before a property": xacro(lambda: "<!--c-->" * 190_000 + PROPERTY),
    "1,000,000 comments before a property": xacro(lambda: "<!---->" * 1_000_000 + PROPERTY, TOO_LARGE),
    "100,000 comments in lines before a property": xacro(lambda: "<!--c-->\n" * 100_000 + PROPERTY),
    "100,000 comments before a macro": xacro(lambda: "<!--c-->" * 100_000 + '<xacro:macro name="m"/>'),
    "100,000 comments before a call": xacro(lambda: '<xacro:macro name="m"/>' + "<!--c-->" * 100_000 + "<xacro:m/>"),
    "100,000 comments before a condition": xacro(lambda: "<!--c-->" * 100_000 + '<xacro:if value="1"/>'),
    "100,000 comments before an argument": xacro(lambda: "<!--c-->" * 100_000 + '<xacro:arg name="a" default="1"/>'),
    "100,000 comments before an include": xacro(lambda: "<!--c-->" * 100_000 + INCLUDE, a_xacro=included(lambda: "")),
    "100,000 comments before each of 20 calls": xacro(
        lambda: f'<xacro:macro name="m">{"<!--c-->" * 100_000}</xacro:macro>' + "<xacro:m/>" * 20
    ),
    "100,000 comments to evaluate": xacro(lambda: "<!-- xacro:eval-comments --><!-- ${1} -->" * 100_000, TOO_LARGE),
    "100,000 comments in a property's block": xacro(
        lambda: (
            f'<xacro:property name="b">{"<!--c-->" * 100_000}</xacro:property>' + '<xacro:insert_block name="b"/>' * 100
        )
    ),
    "100,000 processing instructions before a property": xacro(lambda: "<?a b?>" * 100_000 + PROPERTY),
    "100,000 processing instructions in a URDF": urdf(lambda: "<?a b?>" * 100_000),
    "100,000 CDATA before a property": xacro(lambda: "<![CDATA[ ]]>" * 100_000 + PROPERTY),
    "100,000 CDATA between texts": xacro(lambda: "a<![CDATA[ ]]>\n" * 100_000 + PROPERTY),
    "100,000 references in a text": xacro(lambda: "&#65;&amp;" * 100_000 + PROPERTY),
    "1,000,000 comments in a URDF": urdf(lambda: "<!--c-->" * 1_000_000),
    "a comment of 9 MB": xacro(lambda: f"<!--{'c' * 9_000_000}-->"),
    "a comment of 49 MB in a URDF": urdf(lambda: f"<!--{'c' * 49_000_000}-->", "at most 20,000,000 are read"),
    "a text of 49 MB in a URDF": urdf(lambda: "c" * 49_000_000, "at most 20,000,000 are read"),
    "white space of 49 MB in a URDF": urdf(lambda: "\n" * 49_000_000, "at most 20,000,000 are read"),
    "a text of 9 MB": xacro(lambda: "c" * 9_000_000),
    "lines of 9 MB": xacro(lambda: "\n" * 9_000_000),
    "CDATA of 9 MB": xacro(lambda: f"<![CDATA[{'<' * 9_000_000}]]>", TOO_LARGE),
    "white space of 9 MB between elements": xacro(lambda: ("<a/>" + "\n" * 300) * 30_000, LOADS),
    "a comment of 9 MB included 200 times": xacro(
        lambda: INCLUDE * 200, TOO_LARGE, a_xacro=included(lambda: f"<!--{'c' * 9_000_000}-->")
    ),
    "a text of 9 MB included 200 times": xacro(
        lambda: INCLUDE * 200, TOO_LARGE, a_xacro=included(lambda: "c" * 9_000_000)
    ),
    "CDATA of 9 MB included 200 times": xacro(
        lambda: INCLUDE * 200, TOO_LARGE, a_xacro=included(lambda: f"<![CDATA[{'c' * 9_000_000}]]>")
    ),
    "an attribute of 9 MB included 200 times": xacro(
        lambda: INCLUDE * 200, TOO_LARGE, a_xacro=included(lambda: f'<a b="{"c" * 9_000_000}"/>')
    ),
    "a comment of 100 kB included 10,000 times": xacro(
        lambda: INCLUDE * 10_000, TOO_LARGE, a_xacro=included(lambda: f"<!--{'c' * 100_000}-->")
    ),
    "a comment of 1 MB in 200 files": Case(
        {
            "arm.xacro": lambda: (
                f'<robot name="r" {XMLNS}>' + times(200, '<xacro:include filename="f{0}.xacro"/>') + f"{ARM}</robot>"
            ),
            **{f"f{i}.xacro": included(lambda: f"<!--{'c' * 1_000_000}-->") for i in range(200)},
        },
        TOO_LARGE,
    ),
    "an empty file included 50,000 times": xacro(lambda: INCLUDE * 50_000, TOO_LARGE, a_xacro=included(lambda: "")),
}

LOOKUPS = {
    "50,000 look-ups through 280 macros": xacro(
        lambda: PROPERTY + nested_macros(280, '<a b="${p}"/>' * 50_000), TOO_LARGE
    ),
    "50,000 sums through 280 macros": xacro(
        lambda: PROPERTY + nested_macros(280, "<a>${[p for i in range(1000)][0]}</a>" * 50), TOO_LARGE
    ),
    "functions called through 280 macros": xacro(
        lambda: nested_macros(200, '<a b="${sin(0)+cos(0)}"/>' * 20_000), TOO_LARGE
    ),
    "properties set in 280 macros": xacro(lambda: nested_macros(280, PROPERTY * 20_000), TOO_LARGE),
    "properties removed in 280 macros": xacro(
        lambda: nested_macros(280, (PROPERTY + '<xacro:property name="p" remove="true"/>') * 10_000), TOO_LARGE
    ),
    "global properties set in 280 macros": xacro(
        lambda: nested_macros(280, '<xacro:property name="p" value="1" scope="global"/>' * 20_000), TOO_LARGE
    ),
    "defaults in 280 macros": xacro(
        lambda: PROPERTY + nested_macros(280, '<xacro:property name="p" default="1"/>' * 20_000), TOO_LARGE
    ),
    "macros called in 280 macros": xacro(
        lambda: '<xacro:macro name="m"/>' + nested_macros(280, "<xacro:m/>" * 10_000), TOO_LARGE
    ),
    "blocks inserted in 280 macros": xacro(
        lambda: (
            '<xacro:property name="b"><a/></xacro:property>'
            + nested_macros(280, '<xacro:insert_block name="b"/>' * 10_000)
        ),
        TOO_LARGE,
    ),
    "unknown names in 280 macros": xacro(
        lambda: (
            nested_macros(280, '<xacro:if value="${1}"><a b="$(arg x)"/></xacro:if>' * 5_000)
            + '<xacro:arg name="x" default="1"/>'
        ),
        "missing xacro argument",
    ),
    "dotted access to 15,000 entries": xacro(
        lambda: '<xacro:property name="d" value="${xacro.load_yaml(\'a.yaml\')}"/>' + '<a b="${d.e.k1}"/>' * 20_000,
        LOADS,
        a_yaml=lambda: "e:\n" + times(15_000, "  k{0}: 1\n"),
    ),
    "dotted access to a list of 15,000": xacro(
        lambda: '<xacro:property name="d" value="${xacro.load_yaml(\'a.yaml\')}"/>' + '<a b="${d.e[7]}"/>' * 20_000,
        LOADS,
        a_yaml=lambda: "e:\n" + times(15_000, "  - 1\n"),
    ),
    "a comprehension over dots": xacro(
        lambda: (
            '<xacro:property name="d" value="${xacro.load_yaml(\'a.yaml\')}"/>'
            + '<a b="${[d.e.k1 for i in range(10000)][0]}"/>' * 10
        ),
        TOO_LARGE,
        a_yaml=lambda: "e:\n" + times(15_000, "  k{0}: 1\n"),
    ),
    "a list of dictionaries run over": xacro(
        lambda: (
            '<xacro:property name="d" value="${xacro.load_yaml(\'a.yaml\')}"/>'
            + '<a b="${[[x for x in d.e][0] for i in range(1000)][0]}"/>' * 10
        ),
        TOO_LARGE,
        a_yaml=lambda: "b: &b\n" + times(5_000, "  k{0}: 1\n") + "e: [*b, *b, *b]",
    ),
    "100,000 properties of one name": xacro(lambda: PROPERTY * 100_000, TOO_LARGE),
    "30,000 properties": xacro(lambda: times(30_000, '<xacro:property name="p{0}" value="{0}"/>'), TOO_LARGE),
    "properties that hang on each other": xacro(
        lambda: (
            PROPERTY.replace('"p"', '"p0"')
            + "".join(f'<xacro:property name="p{i + 1}" value="${{p{i} + 1}}"/>' for i in range(5_000))
            + '<a b="${p5000}"/>'
        ),
        "without end",
    ),
    "50,000 macros of one name": xacro(lambda: '<xacro:macro name="m"/>' * 50_000, TOO_LARGE),
    "10,000 macros": xacro(lambda: times(10_000, '<xacro:macro name="m{0}"/>')),
    "a macro of 10,000 parameters": xacro(
        lambda: '<xacro:macro name="m" params="' + times(10_000, "p{0}:=1 ") + '"/><xacro:m/>', TOO_LARGE
    ),
    "a macro of 3,000 parameters called 100 times": xacro(
        lambda: '<xacro:macro name="m" params="' + times(3_000, "p{0}:=1 ") + '"/>' + "<xacro:m/>" * 100, TOO_LARGE
    ),
    "a macro of 2,000 parameters, all given, 50 times": xacro(
        lambda: (
            '<xacro:macro name="m" params="'
            + times(2_000, "p{0} ")
            + '"/>'
            + ("<xacro:m " + times(2_000, 'p{0}="1" ') + "/>") * 50
        ),
        LOADS,
    ),
    "a macro of 5,000 blocks": xacro(
        lambda: '<xacro:macro name="m" params="' + times(5_000, "*p{0} ") + f'"/><xacro:m>{"<a/>" * 5_000}</xacro:m>',
        TOO_LARGE,
    ),
    "a macro of 1,000 blocks called 50 times": xacro(
        lambda: (
            '<xacro:macro name="m" params="'
            + times(1_000, "*p{0} ")
            + '"/>'
            + f"<xacro:m>{'<a/>' * 1_000}</xacro:m>" * 50
        ),
        LOADS,
    ),
    "conditions 90 deep, 500 times": xacro(
        lambda: ('<xacro:if value="1">' * 90 + "<a/>" + "</xacro:if>" * 90) * 500, TOO_LARGE
    ),
    "conditions around 30,000 elements, 60 deep": xacro(
        lambda: '<xacro:if value="1">' * 60 + "<a/>" * 30_000 + "</xacro:if>" * 60, TOO_LARGE
    ),
    "50,000 attributes put on one element": xacro(
        lambda: "<a>" + times(50_000, '<xacro:attribute name="b{0}" value="1"/>') + "</a>", TOO_LARGE
    ),
    "20,000 attributes put on one element": xacro(
        lambda: "<a>" + times(20_000, '<xacro:attribute name="b{0}" value="1"/>') + "</a>", TOO_LARGE
    ),
    "30,000 elements by name": xacro(lambda: times(30_000, '<xacro:element xacro:name="a{0}"/>')),
    "a property of 100,000 digits": xacro(
        lambda: f'<xacro:property name="p" value="{"1" * 100_000}"/>' + '<a b="${p}"/>' * 10
    ),
    "an expression of 9,000 digits": xacro(lambda: f'<a b="${{{"1" * 9_000}}}"/>' * 500, "digits|bits"),
    "1,000 properties of 4,000 digits": xacro(
        lambda: times(1_000, f'<xacro:property name="p{{0}}" value="{"1" * 4_000}"/><a b="${{p{{0}}}}"/>'),
        "bits",
    ),
    "20,000 arguments declared": xacro(lambda: times(20_000, '<xacro:arg name="a{0}" default="1"/>'), TOO_LARGE),
    "20,000 arguments used": xacro(
        lambda: times(20_000, '<xacro:arg name="a{0}" default="1"/><a b="$(arg a{0})"/>'), TOO_LARGE
    ),
    "100,000 arguments used in a text": xacro(lambda: times(100_000, "<a>$$(arg a{0})</a>"), TOO_LARGE),
    "50,000 packages named in a URDF that is a xacro file": xacro(lambda: times(50_000, "<a>package://p{0}/</a>")),
    "10,000 files by a wildcard": Case(
        {
            "arm.xacro": lambda: f'<robot name="r" {XMLNS}><xacro:include filename="parts/*.xacro"/>{ARM}</robot>',
            **{f"parts/f{i}.xacro": included(lambda: "") for i in range(10_000)},
        },
        LOADS,
    ),
    "10,000 files by 100 wildcards": Case(
        {
            "arm.xacro": lambda: (
                f'<robot name="r" {XMLNS}>' + '<xacro:include filename="parts/*a.xacro"/>' * 1_000 + f"{ARM}</robot>"
            ),
            **{f"parts/f{i}.xacro": included(lambda: "") for i in range(10_000)},
        },
        TOO_LARGE,
    ),
    "aliases in YAML": xacro(
        lambda: "<xacro:property name=\"d\" value=\"${xacro.load_yaml('a.yaml')}\"/><a b='${d}'/>",
        TOO_LARGE,
        a_yaml=lambda: "a0: &a0 1\n" + "".join(f"a{i + 1}: &a{i + 1} [" + f"*a{i}," * 9 + "]\n" for i in range(20)),
    ),
    "YAML of 9 MB": xacro(
        lambda: "<xacro:property name=\"d\" value=\"${xacro.load_yaml('a.yaml')}\"/><a b='${d}'/>",
        TOO_LARGE,
        a_yaml=lambda: "a: 1\n" * 1_800_000,
    ),
    "a YAML comment of 9 MB, 100 times": xacro(
        lambda: times(100, "<a b=\"${xacro.load_yaml('a.yaml')}{0}\"/>"), TOO_LARGE, a_yaml=lambda: "#" * 9_000_000
    ),
    "a YAML text of 4 MB": xacro(
        lambda: "<xacro:property name=\"d\" value=\"${xacro.load_yaml('a.yaml')}\"/><a b='${d.a}'/>",
        TOO_LARGE,
        a_yaml=lambda: f'a: "{"x" * 4_000_000}"',
    ),
    "YAML nested 5,000 deep": xacro(
        lambda: "<xacro:property name=\"d\" value=\"${xacro.load_yaml('a.yaml')}\"/><a b='${d}'/>",
        "nested too deeply",
        a_yaml=lambda: "[" * 5_000 + "]" * 5_000,
    ),
}

ATTRIBUTE = 'a{0}="" '
NAMESPACE = 'xmlns:a{0}="b" '


def many_attributes(element: str) -> Text:
    """`element` with 100,000 attributes in the place of @."""
    return lambda: element.replace("@", times(100_000, ATTRIBUTE))


LARGE = {
    **{
        f"100,000 attributes on a {where} of a URDF": urdf(
            many_attributes(element.format(i="x")),
        )
        for where, element in {
            "link": '<link name="x" @/><joint name="x" type="fixed"><parent link="tool"/><child link="x"/></joint>',
            "joint": '<link name="x"/><joint name="x" type="fixed" @><parent link="tool"/><child link="x"/></joint>',
            "child": '<link name="x"/><joint name="x" type="fixed"><parent link="tool"/><child link="x" @/></joint>',
            "limit": '<link name="x"/><joint name="x" type="revolute"><parent link="tool"/><child link="x"/>'
            '<axis xyz="0 0 1"/><limit lower="-1" upper="1" velocity="1" effort="1" @/></joint>',
            "shape": '<link name="x"><visual><geometry><box size="1 1 1" @/></geometry></visual></link>'
            '<joint name="x" type="fixed"><parent link="tool"/><child link="x"/></joint>',
            "mass": '<link name="x"><inertial><mass value="1" @/><inertia ixx="1" iyy="1" izz="1"/></inertial>'
            '</link><joint name="x" type="fixed"><parent link="tool"/><child link="x"/></joint>',
            "foreign element": "<x @/>",
            "simulator's element": "<gazebo @/>",
        }.items()
    },
    "100,000 attributes on the robot": Case(
        {"arm.urdf": lambda: f'<robot name="r" {times(100_000, ATTRIBUTE)}>{ARM}</robot>'}
    ),
    "100,000 attributes on an element of a xacro file": xacro(many_attributes("<a @/>")),
    "100,000 attributes on a property": xacro(many_attributes('<xacro:property name="p" value="1" @/>')),
    "100,000 attributes on a call": xacro(many_attributes('<xacro:macro name="m"/><xacro:m @/>'), "no|none"),
    "10,000 namespaces": Case(
        {"arm.xacro": lambda: f'<robot name="r" {XMLNS} {times(10_000, NAMESPACE)}>{ARM}</robot>'}
    ),
    "1,500,000 attributes": urdf(
        lambda: f"<x {times(1_500_000, ATTRIBUTE)}/>", "more than 250,000 elements and attributes"
    ),
    "an attribute of 49 MB": urdf(lambda: f'<x a="{"b" * 49_000_000}"/>', "at most 20,000,000 are read"),
    "a link's attribute of 19 MB": urdf(
        lambda: (
            f'<link name="x" a="{"b" * 19_000_000}"/><joint name="x" type="fixed"><parent link="tool"/>'
            '<child link="x"/></joint>'
        )
    ),
    "a name of 9 MB": urdf(
        lambda: (
            f'<link name="{"b" * 9_000_000}"/><joint name="x" type="fixed"><parent link="tool"/>'
            f'<child link="{"b" * 9_000_000}"/></joint>'
        ),
        "name",
    ),
    "1,000 names of 9,000 letters": urdf(
        lambda: "".join(
            f'<link name="{"b" * 9_000}{i}"/><joint name="x{i}" type="fixed"><parent link="tool"/>'
            f'<child link="{"b" * 9_000}{i}"/></joint>'
            for i in range(1_000)
        ),
        "name",
    ),
    "an origin of 1,000,000 numbers": urdf(
        lambda: (
            '<link name="x"/><joint name="x" type="fixed"><parent link="tool"/><child link="x"/>'
            f'<origin xyz="{"0 " * 1_000_000}"/></joint>'
        ),
        "origin",
    ),
    "an origin of 5,000,000 digits": urdf(
        lambda: (
            '<link name="x"/><joint name="x" type="fixed"><parent link="tool"/><child link="x"/>'
            f'<origin xyz="0.{"1" * 5_000_000} 0 0"/></joint>'
        ),
        "no number",
    ),
    "a mass of 5,000,000 digits": urdf(
        lambda: (
            f'<link name="x">{INERTIAL.format("0." + "1" * 5_000_000)}</link><joint name="x" type="fixed">'
            '<parent link="tool"/><child link="x"/></joint>'
        ),
    ),
    "an origin of 19 MB of white space": urdf(
        lambda: (
            '<link name="x"/><joint name="x" type="fixed"><parent link="tool"/><child link="x"/>'
            f'<origin xyz="0 {" " * 19_000_000} 0 0"/></joint>'
        ),
    ),
    "1,000,000 foreign elements": urdf(lambda: "<x/>" * 1_000_000, "more than 250,000 elements and attributes"),
    "4,900,000 foreign elements": urdf(lambda: "<x/>" * 4_900_000, "elements"),
    "foreign elements with texts": urdf(lambda: "<x>a</x>" * 1_000_000, "more than 250,000 elements and attributes"),
    "1,000,000 elements in one link": urdf(
        lambda: (
            f'<link name="x">{"<x/>" * 1_000_000}</link><joint name="x" type="fixed"><parent link="tool"/>'
            '<child link="x"/></joint>'
        ),
        "more than 250,000 elements and attributes",
    ),
    "1,000,000 elements in one joint": urdf(
        lambda: (
            f'<link name="x"/><joint name="x" type="fixed">{"<x/>" * 1_000_000}<parent link="tool"/>'
            '<child link="x"/></joint>'
        ),
        "more than 250,000 elements and attributes",
    ),
    "40,000 limits in one joint": urdf(
        lambda: (
            '<link name="x"/><joint name="x" type="revolute"><parent link="tool"/><child link="x"/>'
            f'<axis xyz="0 0 1"/>{LIMIT * 40_000}</joint>'
        ),
    ),
    "15,000 masses in one link": urdf(
        lambda: (
            f'<link name="x">{INERTIAL.format(1) * 15_000}</link><joint name="x" type="fixed">'
            '<parent link="tool"/><child link="x"/></joint>'
        ),
    ),
    "30,000 simulator's elements": urdf(
        lambda: times(30_000, '<gazebo reference="l{0}"><material>Gazebo/Red</material></gazebo>')
    ),
    "30,000 transmissions": urdf(
        lambda: times(30_000, '<transmission name="t{0}"><joint name="j1"/><actuator name="a{0}"/></transmission>')
    ),
    "50,000 materials": urdf(lambda: times(50_000, MATERIAL)),
    "9,000 visuals on a link": urdf(
        lambda: (
            f'<link name="x">{times(9_000, VISUAL)}</link><joint name="x" type="fixed"><parent link="tool"/>'
            '<child link="x"/></joint>'
        )
    ),
    "100,000 visuals on a link": urdf(
        lambda: (
            f'<link name="x">{times(100_000, VISUAL)}</link><joint name="x" type="fixed"><parent link="tool"/>'
            '<child link="x"/></joint>'
        ),
        "shapes|elements",
    ),
    "100,000 collisions on a link": urdf(
        lambda: (
            f'<link name="x">{times(100_000, COLLISION)}</link><joint name="x" type="fixed"><parent link="tool"/>'
            '<child link="x"/></joint>'
        ),
        "shapes|elements",
    ),
    "5,000 collisions on a link": urdf(
        lambda: (
            f'<link name="x">{times(5_000, COLLISION)}</link><joint name="x" type="fixed"><parent link="tool"/>'
            '<child link="x"/></joint>'
        )
    ),
    "9,000 meshes that are nowhere": urdf(
        lambda: (
            f'<link name="x">{times(9_000, MESH.format("m{0}.stl"))}</link><joint name="x" type="fixed">'
            '<parent link="tool"/><child link="x"/></joint>'
        )
    ),
    "9,000 meshes of 9,000 packages": urdf(
        lambda: (
            f'<link name="x">{times(9_000, MESH.format("package://p{0}/m.stl"))}</link>'
            '<joint name="x" type="fixed"><parent link="tool"/><child link="x"/></joint>'
        )
    ),
    "20,000 materials on one link": urdf(
        lambda: (
            f'<link name="x"><visual>{times(20_000, MATERIAL)}<geometry><box size="1 1 1"/></geometry></visual>'
            '</link><joint name="x" type="fixed"><parent link="tool"/><child link="x"/></joint>'
        )
    ),
}

TREES = {
    "2,000 links side by side": urdf(lambda: links(2_000, lambda i: "tool")),
    "3,900 links side by side": urdf(lambda: links(3_900, lambda i: "tool")),
    "20,000 links side by side": urdf(lambda: links(20_000, lambda i: "tool"), "<link>|elements and attributes"),
    "100,000 links side by side": urdf(lambda: links(100_000, lambda i: "tool"), "<link>|elements and attributes"),
    "200,000 links side by side": urdf(lambda: links(200_000, lambda i: "base"), "at most 20,000,000 are read"),
    "900 links in a chain": urdf(lambda: links(900, chain)),
    "2,000 links in a chain": urdf(lambda: links(2_000, chain), "chain of more than"),
    "3,900 links in chains of 50": urdf(lambda: links(3_900, hanging(50))),
    "3,900 links in chains of 900": urdf(lambda: links(3_900, hanging(900))),
    "20,000 links in chains of 900": urdf(lambda: links(20_000, hanging(900)), "<link>|elements and attributes"),
    "3,900 links with masses": urdf(
        lambda: links(3_900, lambda i: "tool").replace('"/><joint', f'">{INERTIAL.format(1)}</link><joint')
    ),
    "3,900 links with shapes": urdf(
        lambda: links(3_900, lambda i: "tool").replace('"/><joint', f'">{COLLISION.format(1)}</link><joint')
    ),
    "100,000 links without joints": urdf(
        lambda: times(100_000, '<link name="l{0}"/>'), "<link>|elements and attributes"
    ),
    "3,000 links without joints": urdf(lambda: times(3_000, '<link name="l{0}"/>'), "root links"),
    "100,000 joints of one link": urdf(
        lambda: times(100_000, '<joint name="k{0}" type="fixed"><parent link="base"/><child link="tool"/></joint>'),
        "<joint>|elements and attributes",
    ),
    "3,000 joints of one link": urdf(
        lambda: times(3_000, '<joint name="k{0}" type="fixed"><parent link="base"/><child link="tool"/></joint>'),
        "two parents",
    ),
    "3,000 joints between nothing": urdf(
        lambda: times(3_000, '<joint name="k{0}" type="fixed"><parent link="x{0}"/><child link="y{0}"/></joint>'),
        "not defined",
    ),
    "3,000 joints of an unknown type": urdf(lambda: links(3_000, lambda i: "tool", kind="strange"), "is unknown"),
    "3,000 joints with words unread": urdf(
        lambda: links(3_000, lambda i: "tool", more='<orgin xyz="0 0 1"/><origin xzy="1 1 1"/>')
    ),
    "3,000 joints with bad numbers": urdf(
        lambda: links(3_000, lambda i: "tool", more='<origin xyz="a b c"/>'), "malformed"
    ),
    "3,000 turned by degrees": urdf(
        lambda: links(3_000, lambda i: "tool", more='<origin rpy="90 0 0"/>'),
    ),
    "3,000 masses that are none": urdf(
        lambda: links(3_000, lambda i: "tool").replace('"/><joint', f'">{INERTIAL.format("x")}</link><joint')
    ),
    "3,000 shapes without a size": urdf(
        lambda: links(3_000, lambda i: "tool").replace(
            '"/><joint', '"><visual><geometry><box/></geometry></visual></link><joint'
        )
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
    "145 joints in a chain": urdf(lambda: links(143, chain, "continuous", '<origin xyz="0.1 0 0"/>')),
    "145 joints side by side": urdf(lambda: links(143, lambda i: "base", "continuous")),
    "a chain of 145 mimics": urdf(lambda: mimics(143, lambda i: f"k{i - 1}" if i else "j2")),
    "145 joints and 3,700 links": urdf(
        lambda: (
            links(143, chain, "continuous", '<origin xyz="0.1 0 0"/>')
            + links(3_700, lambda i: "base").replace('"l', '"x').replace('"k', '"y')
        )
    ),
    "240 joints in a chain": urdf(lambda: links(238, chain, "continuous", '<origin xyz="0.1 0 0"/>'), "moving joints"),
    "240 joints side by side": urdf(lambda: links(238, lambda i: "base", "continuous"), "moving joints"),
    "1,000 joints side by side": urdf(
        lambda: links(1_000, lambda i: "tool", "continuous"), "moving joints|nothing that is an arm"
    ),
    "100 planar joints": urdf(lambda: links(100, chain, "planar"), "moving joints"),
    "100 floating joints": urdf(lambda: links(100, lambda i: "base", "floating")),
    "3,000 floating joints": urdf(lambda: links(3_000, lambda i: "base", "floating"), "moving joints"),
    "a chain of 100 mimics": urdf(lambda: mimics(100, lambda i: f"k{i - 1}" if i else "j2")),
    "a chain of 240 mimics": urdf(lambda: mimics(240, lambda i: f"k{i - 1}" if i else "j2"), "moving joints"),
    "240 mimics of one joint": urdf(lambda: mimics(240, lambda i: "j2"), "moving joints"),
    "100 mimics of one joint": urdf(lambda: mimics(100, lambda i: "j2")),
    "100 mimics in a circle": urdf(lambda: mimics(100, lambda i: f"k{(i + 1) % 100}"), "circle"),
    "100 joints and 3,000 links": urdf(
        lambda: (
            links(98, chain, "continuous", '<origin xyz="0.1 0 0"/>')
            + links(3_000, lambda i: "base").replace('"l', '"x').replace('"k', '"y')
        )
    ),
    "200 joints and 3,700 links": urdf(
        lambda: (
            links(198, chain, "continuous", '<origin xyz="0.1 0 0"/>')
            + links(3_700, lambda i: "base").replace('"l', '"x').replace('"k', '"y')
        ),
        "moving joints",
    ),
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
    "10,000 pairs of links that are not there": beside(
        lambda: times(10_000, '<disable_collisions link1="x{0}" link2="y{0}"/>')
    ),
    "200 silent links of 3,000": beside(
        lambda: times(200, '<disable_default_collisions link="l{0}"/>'), lambda: links(3_000, lambda i: "tool")
    ),
    "200 groups of 500 joints": beside(
        lambda: "".join(f'<group name="g{i}">' + times(60, '<joint name="k{0}"/>') + "</group>" for i in range(200)),
        lambda: links(500, lambda i: "tool"),
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
    "5,000 named states": beside(
        lambda: (
            '<group name="g"><chain base_link="base" tip_link="tool"/></group>'
            + times(
                5_000,
                '<group_state name="s{0}" group="g"><joint name="j1" value="0"/><joint name="j2" value="0"/>'
                "</group_state>",
            )
        )
    ),
    "5,000 states outside the limits": beside(
        lambda: (
            '<group name="g"><chain base_link="base" tip_link="tool"/></group>'
            + times(
                5_000,
                '<group_state name="s{0}" group="g"><joint name="j1" value="9"/><joint name="j2" value="9"/>'
                "</group_state>",
            )
        )
    ),
    "a state of 20,000 joints": beside(
        lambda: '<group_state name="s" group="g">' + times(20_000, '<joint name="x{0}" value="0"/>') + "</group_state>"
    ),
    "100,000 comments in an SRDF": beside(lambda: "<!--c-->" * 100_000),
    "50,000 attributes in an SRDF": beside(lambda: f"<a {times(50_000, ATTRIBUTE)}/>"),
    "an SRDF that is a xacro file of comments": urdf(
        lambda: "",
        arm_srdf=lambda: f'<robot name="r" {XMLNS}>{"<!--c-->" * 100_000}{PROPERTY}</robot>',
    ),
    "2,000 SRDFs": Case(
        {
            "arm.urdf": lambda: f'<robot name="r">{ARM}</robot>',
            **{f"s{i}.srdf": lambda: SRDF.format("<a/>") for i in range(2_000)},
        }
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
    "200 manifests of 1 MB": searching(manifests(200, 990_000)),
    "200 manifests of 1 MB, the name at the end": searching(manifests(200, 990_000, late=True)),
    "5,000 manifests of 20 kB": searching(manifests(5_000, 20_000)),
    "5,000 manifests of 20 kB, the name at the end": searching(manifests(5_000, 20_000, late=True)),
    "links in circles": searching(loops, "--package-dir", "."),
    "a folder of 40,000": searching(wide(2_000), "--package-dir", "."),
    "the whole disk": searching(lambda folder: None, "--package-dir", "/"),
    "a loop as folder of packages": Case(
        {"arm.urdf": lambda: f'<robot name="r">{ARM}</robot>'}, "loop|usable", ("--package-dir", "self"), loops
    ),
}

CASES: dict[str, Case] = {**COMMENTS, **LOOKUPS, **LARGE, **TREES, **BESIDE, **FOLDERS}
