"""What a xacro file may cost: what runs away is refused soon, what is only long expands."""

from __future__ import annotations

import re
import resource

import pytest

from hostile.sandbox import Sandbox, watched
from hostile.sandbox import place as place
from twistarm.description.expansion import expand

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


QUICK = ("texts that double", "a macro that calls itself", "arguments that never close", "elements without end",
         "keys of one hash", "an element named again and again")  # fmt: skip


@pytest.mark.parametrize("case", [pytest.param(c, marks=() if c in QUICK else pytest.mark.slow) for c in RUNAWAY])
def test_what_runs_away_is_refused_soon_and_in_one_line(case: str, place: Sandbox) -> None:
    place.seconds = 0.5
    hashes = "".join(f"{i * (2**61 - 1)}: 1\n" for i in range(100_000))
    message = place.refuse(
        RUNAWAY[case], {"a.yaml": "a: [1, 2, 3]", "hashes.yaml": hashes, "text.yaml": f"a: {'x ' * 20_000}"}
    )
    assert str(place.folder / "arm") in message


LONG = {
    "parameters that are copied for each other": (
        '<xacro:macro name="m" params="' + "".join(f"p{i}:=1 " for i in range(10_000)) + '"/><xacro:m/>'
    ),
    "parameters over which xacro's own pattern never comes to an end": (
        f'<xacro:macro name="m" params="a:={"a" * 5000}\'"/>'
    ),
    "a million dollars": f'<a b="{"a$" * 1_000_000}"/>',
    "a comment of eight million characters": f"<!--{'a' * 8_000_000}-->",
    "a YAML comment of a million characters": "<a b=\"${xacro.load_yaml('a.yaml')}\"/>",
}


@pytest.mark.parametrize("case", LONG)
def test_what_is_only_long_expands_in_time(case: str, place: Sandbox) -> None:
    assert "<robot" in place.expand(LONG[case], {"a.yaml": f"#{'a' * 1_000_000}\na: 1"})
    place.untouched()


@pytest.mark.slow
@pytest.mark.parametrize("case", ["macros that double", "texts that double", "a large body copied"])
def test_a_process_that_runs_away_ends_after_the_time_that_is_allowed(case: str, place: Sandbox) -> None:
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    message = place.refuse(RUNAWAY[case])
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    assert re.search("takes more work than any robot's description needs: more than (6 s|400 MB); look for", message)
    assert after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime < 10.0


def test_the_next_file_is_expanded_after_one_that_ran_away(place: Sandbox) -> None:
    first = watched.process()
    place.seconds = 0.5
    place.refuse(RUNAWAY["a large body copied"])
    place.seconds = expand.SECONDS
    assert not first.alive
    assert "<a/>" in place.expand("<a/>")
    second = watched.process()
    assert "<b/>" in place.expand("<b/>")
    assert watched.process() is second
