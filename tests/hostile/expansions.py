"""xacro files that ask for much work: comments in rows, and names looked up through many scopes."""

from __future__ import annotations

from .sandbox import XMLNS
from .texts import ARM, INCLUDE, LOADS, PROPERTY, TOO_LARGE, Case, included, nested_macros, times, urdf, xacro

COMMENTS = {
    "100,000 comments before a property": xacro(lambda: "<!--c-->" * 100_000 + PROPERTY),
    "100,000 comments before each of 20 calls": xacro(
        lambda: f'<xacro:macro name="m">{"<!--c-->" * 100_000}</xacro:macro>' + "<xacro:m/>" * 20
    ),
    "1,000,000 comments in a URDF": urdf(lambda: "<!--c-->" * 1_000_000),
    "a comment of 9 MB": xacro(lambda: f"<!--{'c' * 9_000_000}-->"),
    "white space of 9 MB between elements": xacro(lambda: ("<a/>" + "\n" * 300) * 30_000, LOADS),
    "a comment of 9 MB included 200 times": xacro(
        lambda: INCLUDE * 200, TOO_LARGE, a_xacro=included(lambda: f"<!--{'c' * 9_000_000}-->")
    ),
}

LOOKUPS = {
    "50,000 look-ups through 280 macros": xacro(
        lambda: PROPERTY + nested_macros(280, '<a b="${p}"/>' * 50_000), TOO_LARGE
    ),
    "properties set in 280 macros": xacro(lambda: nested_macros(280, PROPERTY * 20_000), TOO_LARGE),
    "dotted access to 15,000 entries": xacro(
        lambda: '<xacro:property name="d" value="${xacro.load_yaml(\'a.yaml\')}"/>' + '<a b="${d.e.k1}"/>' * 20_000,
        LOADS,
        a_yaml=lambda: "e:\n" + times(15_000, "  k{0}: 1\n"),
    ),
    "a comprehension over dots": xacro(
        lambda: (
            '<xacro:property name="d" value="${xacro.load_yaml(\'a.yaml\')}"/>'
            + '<a b="${[d.e.k1 for i in range(10000)][0]}"/>' * 10
        ),
        LOADS,
        a_yaml=lambda: "e:\n" + times(15_000, "  k{0}: 1\n"),
    ),
    "properties that hang on each other": xacro(
        lambda: (
            PROPERTY.replace('"p"', '"p0"')
            + "".join(f'<xacro:property name="p{i + 1}" value="${{p{i} + 1}}"/>' for i in range(5_000))
            + '<a b="${p5000}"/>'
        ),
        "without end",
    ),
    "a macro of 5,000 blocks": xacro(
        lambda: '<xacro:macro name="m" params="' + times(5_000, "*p{0} ") + f'"/><xacro:m>{"<a/>" * 5_000}</xacro:m>',
        TOO_LARGE,
    ),
    "conditions around 30,000 elements, 60 deep": xacro(
        lambda: '<xacro:if value="1">' * 60 + "<a/>" * 30_000 + "</xacro:if>" * 60, TOO_LARGE
    ),
    "50,000 attributes put on one element": xacro(
        lambda: "<a>" + times(50_000, '<xacro:attribute name="b{0}" value="1"/>') + "</a>", TOO_LARGE
    ),
    "a property of 100,000 digits": xacro(
        lambda: f'<xacro:property name="p" value="{"1" * 100_000}"/>' + '<a b="${p}"/>' * 10
    ),
    "an expression of 9,000 digits": xacro(lambda: f'<a b="${{{"1" * 9_000}}}"/>' * 500, "digits|bits"),
    "50,000 packages named in a URDF that is a xacro file": xacro(lambda: times(50_000, "<a>package://p{0}/</a>")),
    "10,000 files by a wildcard": Case(
        {
            "arm.xacro": lambda: f'<robot name="r" {XMLNS}><xacro:include filename="parts/*.xacro"/>{ARM}</robot>',
            **{f"parts/f{i}.xacro": included(lambda: "") for i in range(10_000)},
        },
        LOADS,
    ),
}
