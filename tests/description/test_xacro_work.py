"""What a xacro file may cost: what runs away is refused soon, what is only long expands."""

from __future__ import annotations

from pathlib import Path

import pytest

from hostile.sandbox import Sandbox
from hostile.sandbox import place as place
from twistarm.description.expansion import hooks
from twistarm.description.expansion.expand import expand_xacro
from twistarm.description.expansion.work import MAX_WORK, Work
from twistarm.description.packages import package_index

DEEP = 40


def doubling(first: str, other: str) -> str:
    """`first`, then forty times `other` with {0} twice as much as {1}."""
    return first + "".join(other.format(i + 1, i) for i in range(DEEP))


RUNAWAY = {
    "macros that double": doubling(
        '<xacro:macro name="m0"><link name="a"/></xacro:macro>',
        '<xacro:macro name="m{0}"><xacro:m{1}/><xacro:m{1}/></xacro:macro>',
    )
    + f"<xacro:m{DEEP}/>",
    "blocks that double": doubling(
        '<xacro:property name="b0"><a/></xacro:property>',
        '<xacro:property name="b{0}"><x><xacro:insert_block name="b{1}"/><xacro:insert_block name="b{1}"/></x>'
        "</xacro:property>",
    )
    + f'<xacro:insert_block name="b{DEEP}"/>',
    "texts that double": doubling(
        '<xacro:property name="p0" value="ha"/>', '<xacro:property name="p{0}" value="${{p{1}}}${{p{1}}}"/>'
    )
    + f'<link name="${{p{DEEP}}}"/>',
    "lists that double": doubling(
        '<xacro:property name="p0" value="${[1]}"/>', '<xacro:property name="p{0}" value="${{[p{1}, p{1}]}}"/>'
    )
    + f'<link name="${{p{DEEP}}}"/>',
    "lists that are made to double": doubling(
        '<xacro:property name="p0" value="${[]}"/>',
        '<xacro:property name="p{0}" value="${{[]}}"/><a n="${{[p{0}.append(p{1}), p{0}.append(p{1})]}}"/>',
    )
    + f'<link name="${{p{DEEP}}}"/>',
    "numbers that double their digits": doubling(
        '<xacro:property name="p0" value="10"/>', '<xacro:property name="p{0}" value="${{p{1} * p{1}}}"/>'
    )
    + f'<link name="${{p{DEEP}}}"/>',
    "arguments that double": doubling(
        '<xacro:arg name="p0" default="ha"/>', '<xacro:arg name="p{0}" default="$(arg p{1})$(arg p{1})"/>'
    )
    + f'<link name="$(arg p{DEEP})"/>',
    "a macro that calls itself": '<xacro:macro name="m" params="n"><xacro:m n="${n+1}"/></xacro:macro><xacro:m n="0"/>',
    "a name that is called for ever": '<xacro:macro name="a"><xacro:call macro="a"/></xacro:macro><xacro:a/>',
    "properties in a circle": '<xacro:property name="a" value="${b}"/><xacro:property name="b" value="${a}"/>'
    '<link name="${a}"/>',
    "parameters that are copied for each other": (
        '<xacro:macro name="m" params="' + "".join(f"p{i}:=1 " for i in range(10_000)) + '"/><xacro:m/>'
    ),
    "parameters without end": f'<xacro:macro name="m" params="{"a " * 1_000_000}"/>',
    "expressions without end": f'<link name="{"${1}" * 1_000_000}"/>',
    "brackets in a property's name": f'<xacro:property name="{"(" * 100_000}" value="1"/>',
    "arguments that never close": f"<![CDATA[{'<xacro:arg ' * 300_000}]]>${{1/0}}",
    "elements without end": "<a/>" * 1_000_000,
    "a large body copied": '<xacro:macro name="m">' + "<a/>" * 20_000 + "</xacro:macro>" + "<xacro:m/>" * 1000,
    "a block inserted again and again": f'<xacro:property name="b">{"<a/>" * 300}</xacro:property>'
    + '<b><xacro:insert_block name="b"/></b>' * 5000,
    "a long text in a block": f'<xacro:property name="b"><a b="{"a" * 1_000_000}"/></xacro:property>'
    + '<xacro:insert_block name="b"/>' * 1000,
    "expressions of their own": "".join(f'<a b="${{{i}{"+1" * 190}}}"/>' for i in range(1800)),
    "a long text copied": f'<xacro:macro name="m"><a b="{"a" * 1_000_000}"/></xacro:macro>' + "<xacro:m/>" * 1000,
    "attributes without end": "<a " + " ".join(f'a{i}=""' for i in range(700_000)) + "/>",
    "a sum in every text": "<a>${[i for i in range(50000)]}</a>" * 1000,
    "YAML loaded again and again": "".join(f"<a b=\"${{xacro.load_yaml('a.yaml')}}{i}\"/>" for i in range(100_000)),
    "a long text cut into pieces again and again": f'<xacro:macro name="m"><a b="{"a$" * 100_000}"/></xacro:macro>'
    + "<xacro:m/>" * 1000,
    "a long command again and again": '<xacro:property name="a" value="${\'a\' * 500000}"/>'
    + "".join(f'<b c="$(optenv NONE{i} ${{a}})"/>' for i in range(1000)),
    "packages that are nowhere": "".join(f'<a b="$(find p{i})"/>' for i in range(200_000)),
    "keys of one hash": "<a b=\"${xacro.load_yaml('hashes.yaml')}\"/>",
    "an element named again and again": '<xacro:element xacro:name="xacro:element"/>',
}


@pytest.mark.parametrize("case", RUNAWAY)
def test_what_runs_away_is_refused_soon_and_in_one_line(case: str, place: Sandbox) -> None:
    hashes = "".join(f"{i * (2**61 - 1)}: 1\n" for i in range(100_000))
    message = place.refuse(
        RUNAWAY[case], {"a.yaml": "a: [1, 2, 3]", "hashes.yaml": hashes, "text.yaml": f"a: {'x ' * 20_000}"}
    )
    assert str(place.folder / "arm") in message


LONG = {
    "parameters over which xacro's own pattern never comes to an end": (
        f'<xacro:macro name="m" params="a:={"a" * 5000}\'"/>'
    ),
    "a million dollars": f'<a b="{"a$" * 1_000_000}"/>',
    "a comment of eight million characters": f"<!--{'a' * 8_000_000}-->",
    "a YAML comment of a million characters": "<a b=\"${xacro.load_yaml('a.yaml')}\"/>",
}


@pytest.mark.slow
@pytest.mark.parametrize("case", RUNAWAY)
def test_the_whole_of_what_is_allowed_is_over_in_seconds(case: str, place: Sandbox) -> None:
    place.work = MAX_WORK
    test_what_runs_away_is_refused_soon_and_in_one_line(case, place)


@pytest.mark.parametrize("case", LONG)
def test_what_is_only_long_expands_in_time(case: str, place: Sandbox) -> None:
    place.work = MAX_WORK
    assert "<robot" in place.expand(LONG[case], {"a.yaml": f"#{'a' * 1_000_000}\na: 1"})
    place.untouched()


def spent(place: Sandbox, inside: str) -> int:
    place.expand(inside)
    return place.spent


def test_siblings_are_paid_for_by_each_element_exchanged_among_them(place: Sandbox) -> None:
    exchanged, siblings = '<xacro:if value="1"/>' * 10, "<a/>" * 1000
    apart, among = (spent(place, text) for text in (f"{exchanged}<b>{siblings}</b>", f"<b/>{exchanged}{siblings}"))
    assert among - apart > 9 * 1000 // hooks.SIBLINGS_PER_UNIT


def test_a_real_arm_takes_a_small_part_of_what_is_allowed(models: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    work = Work()
    monkeypatch.setattr(hooks, "Work", lambda: work)
    path = models / "ur_description" / "urdf" / "ur.urdf.xacro"
    expand_xacro(path, package_index(path), {"name": "ur", "ur_type": "ur5e"})
    assert MAX_WORK - work.left < MAX_WORK // 10
