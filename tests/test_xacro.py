"""xacro without ROS: packages, arguments, includes, and every raw error in one line that helps."""

from __future__ import annotations

import contextlib
import os
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import xacro.substitution_args

from hostile import Sandbox, sandbox
from twistarm import load_arm
from twistarm.description.expansion import hooks
from twistarm.description.expansion.expand import expand_xacro, is_xacro
from twistarm.description.expansion.module import own_xacro
from twistarm.description.expansion.work import MAX_WORK, Work
from twistarm.description.packages import package_index
from twistarm.errors import DescriptionError, InputError, TwistarmError
from urdf_text import joint, robot, write

ARM = robot(joint("a", "base_link", "upper"), joint("b", "upper", "tool0"))
XMLNS = 'xmlns:xacro="http://www.ros.org/wiki/xacro"'


def as_xacro(inside: str) -> str:
    return ARM.replace('<robot name="tiny">', f'<robot name="tiny" {XMLNS}>{inside}')


def package(folder: Path, name: str, files: dict[str, str] | None = None) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "package.xml").write_text(f"<package><name>{name}</name></package>")
    for file, text in (files or {}).items():
        (folder / file).write_text(text)
    return folder


FAILS = {
    "a package that an include needs": (
        as_xacro('<xacro:include filename="$(find elsewhere)/a.xacro"/>'),
        "package 'elsewhere' not found; searched",
    ),
    "a missing argument": (
        as_xacro(
            '<xacro:arg name="size" default="2"/><xacro:property name="m" value="$(arg ar_model)"/><link name="${m}"/>'
        ),
        "missing xacro argument ar_model; all arguments: size (default '2'), ar_model (required); "
        "pass xacro_args={'ar_model': …}",
    ),
    "an argument used before its default": (
        as_xacro('<xacro:arg name="name" default="ur"/>').replace('name="tiny"', 'name="$(arg name)"'),
        "missing xacro argument name; all arguments: name (default 'ur'); pass xacro_args={'name': …}",
    ),
    "an argument never declared": (
        as_xacro('<xacro:property name="m" value="$(arg dof)"/><link name="${m}"/>'),
        "missing xacro argument dof; all arguments: dof (required)",
    ),
    "no namespace": (
        ARM.replace("</robot>", '<xacro:property name="a" value="1"/></robot>'),
        "a tag's prefix is not declared: add xmlns:xacro=",
    ),
    "not XML": ("<robot", "not well-formed XML"),
    "an unknown macro": (
        as_xacro("<xacro:arm_of_mine/>"),
        "xacro cannot expand it: unknown macro name: xacro:arm_of_mine",
    ),
    "an undefined name": (as_xacro('<link name="${nothing}"/>'), "name 'nothing' is not defined"),
    "a macro without end": (
        as_xacro('<xacro:macro name="m"><xacro:m/></xacro:macro><xacro:m/>'),
        "a macro, a property or an included file refers to itself without end",
    ),
    "an argument without a default": (as_xacro('<xacro:arg name="h"/>'), "a <xacro:arg> has no default="),
    "a YAML file that is not there": (
        as_xacro("<link name=\"${xacro.load_yaml('no.yaml')}\"/>"),
        "no.yaml",
    ),
    "a parameter that the macro has not": (
        as_xacro('<xacro:macro name="m" params="a"><link name="${a}"/></xacro:macro><xacro:m a="1" sim="2"/>'),
        "macro 'm': xacro cannot expand it: Invalid parameter \"sim\": the macro has none of that name; add "
        "it to the params= of the macro, or leave it out of the call",
    ),
    "a parameter left out": (
        as_xacro('<xacro:macro name="m" params="a b"><link name="${a}"/></xacro:macro><xacro:m a="1"/>'),
        "macro 'm': xacro cannot expand it: Undefined parameters [b]",
    ),
    "a property without its prefix": (
        as_xacro('<property name="h" value="1"/><link name="l${h}"/>'),
        "name 'h' is not defined when evaluating expression 'h'; write <xacro:property name=\"h\" …>",
    ),
    "an argument asked for in Python": (
        as_xacro("<link name=\"${xacro.arg('side')}\"/>"),
        "missing xacro argument side; all arguments: none; pass xacro_args={'side': …}",
    ),
    "a message of its own": (as_xacro("${xacro.fatal('wrong', 'arm')}"), "xacro cannot expand it: wrong arm when"),
    "an unfinished expression": (as_xacro('<link name="${a"/>'), "xacro cannot expand it: invalid expression: ${a"),
    "a missing include": (as_xacro('<xacro:include filename="nowhere.xacro"/>'), "No such file or directory"),
}


@pytest.mark.parametrize("case", FAILS)
def test_fails_in_one_line(case: str, tmp_path: Path) -> None:
    text, message = FAILS[case]
    path = write(tmp_path, text, "arm.urdf.xacro")
    with pytest.raises(DescriptionError) as caught:
        load_arm(path)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)
    assert "arm.urdf.xacro" in str(caught.value)


DEEP = 40


def doubling(first: str, other: str) -> str:
    """`first`, then forty times `other` with {0} twice as much as {1}."""
    return first + "".join(other.format(i + 1, i) for i in range(DEEP))


def macros_that_double(body: str, call: str) -> str:
    return (
        f'<xacro:macro name="m0">{body}</xacro:macro>'
        + doubling("", '<xacro:macro name="m{0}"><xacro:m{1}/><xacro:m{1}/></xacro:macro>').replace("<xacro:m", call)
        + f"<xacro:m{DEEP}/>"
    )


RUNAWAY = {
    "macros that double": macros_that_double('<link name="a"/>', "<xacro:m"),
    "macros that double and hold nothing": macros_that_double("", "<xacro:m"),
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
    "sums that double": doubling(
        '<xacro:property name="p0" value="${\'ha\'}"/>', '<xacro:property name="p{0}" value="${{p{1} + p{1}}}"/>'
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
    "macros that call each other": '<xacro:macro name="a"><xacro:b/></xacro:macro><xacro:macro name="b"><xacro:a/>'
    "</xacro:macro><xacro:a/>",
    "a name that is called for ever": '<xacro:macro name="a"><xacro:call macro="a"/></xacro:macro><xacro:a/>',
    "properties in a circle": '<xacro:property name="a" value="${b}"/><xacro:property name="b" value="${a}"/>'
    '<link name="${a}"/>',
    "parameters without end": f'<xacro:macro name="m" params="{"a " * 1_000_000}"/>',
    "expressions without end": f'<link name="{"${1}" * 1_000_000}"/>',
    "brackets in a property's name": f'<xacro:property name="{"(" * 100_000}" value="1"/>',
    "minus signs in a property's name": f'<xacro:property name="{"-" * 100_000}a" value="1"/>',
    "arguments that never close": f"<![CDATA[{'<xacro:arg ' * 300_000}]]>${{1/0}}",
    "comments that never close": f"<![CDATA[{'<!--' * 700_000}]]>${{1/0}}",
    "elements without end": "<a/>" * 1_000_000,
    "elements of xacro without end": '<xacro:property name="a" value="1"/>' * 200_000,
    "conditions side by side without end": '<xacro:if value="1"><a/></xacro:if>' * 100_000,
    "calls side by side without end": '<xacro:macro name="m"><a/></xacro:macro>' + "<xacro:m/>" * 200_000,
    "a large body copied": '<xacro:macro name="m">' + "<a/>" * 20_000 + "</xacro:macro>" + "<xacro:m/>" * 1000,
    "a block inserted again and again": f'<xacro:property name="b">{"<a/>" * 300}</xacro:property>'
    + '<b><xacro:insert_block name="b"/></b>' * 5000,
    "expressions of their own": "".join(f'<a b="${{{i}{"+1" * 190}}}"/>' for i in range(1800)),
    "a long text copied": f'<xacro:macro name="m"><a b="{"a" * 1_000_000}"/></xacro:macro>' + "<xacro:m/>" * 1000,
    "attributes without end": "<a " + " ".join(f'a{i}=""' for i in range(700_000)) + "/>",
    "elements nested without end": "<a>" * 5000 + "</a>" * 5000,
    "a sum in every text": "<a>${[i for i in range(50000)]}</a>" * 1000,
    "a namespace printed again and again": "".join(f'<a b="${{math}}{i}"/>' for i in range(100_000)),
    "YAML loaded again and again": "".join(f"<a b=\"${{xacro.load_yaml('a.yaml')}}{i}\"/>" for i in range(100_000)),
    "a long text cut into pieces again and again": f'<xacro:macro name="m"><a b="{"a$" * 100_000}"/></xacro:macro>'
    + "<xacro:m/>" * 1000,
    "a long command again and again": '<xacro:property name="a" value="${\'a\' * 500000}"/>'
    + "".join(f'<b c="$(optenv NONE{i} ${{a}})"/>' for i in range(1000)),
    "packages that are nowhere": "".join(f'<a b="$(find p{i})"/>' for i in range(200_000)),
    "a text in YAML again and again": "".join(f"<a b=\"${{xacro.load_yaml('text.yaml')}}{i}\"/>" for i in range(1000)),
    "keys of one hash": "<a b=\"${xacro.load_yaml('hashes.yaml')}\"/>",
    "an element named again and again": '<xacro:element xacro:name="xacro:element"/>',
}


@pytest.fixture
def place(tmp_path: Path) -> Sandbox:
    return sandbox(tmp_path)


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
    "a million escaped dollars": f'<a b="{"$" * 1_000_000}{{"/>',
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


BAD_YAML = {
    "aliases that double": "\n".join(
        ["a0: &a0 [ha]", *(f"a{i + 1}: &a{i + 1} [{', '.join([f'*a{i}'] * 10)}]" for i in range(12))]
    ),
    "merges that double": "\n".join(
        ["a0: &a0 {k: 1}", *(f"a{i + 1}: &a{i + 1} {{<<: [{', '.join([f'*a{i}'] * 10)}]}}" for i in range(12))]
    ),
    "itself": "a: &a [*a]",
    "itself by merging": "a: &a {<<: *a}",
    "an object": "!!python/object/apply:os.system ['touch @MARKER']",
    "a name of Python": "a: !!python/name:os.system",
    "a module": "a: !!python/module:os",
    "a new object": "a: !!python/object/new:subprocess.Popen [['touch', '@MARKER']]",
    "an unknown tag": "a: !secret '@SECRET'",
    "an escape in a unit": "a: !degrees ().__class__.__base__.__subclasses__()",
    "a load in a unit": "a: !degrees load_yaml('@SECRET')['key']",
    "a power in a unit": "a: !radians 9**9**9",
    "no number in a unit": "a: !degrees left",
    "a number in base 60": "a: 1" + ":1" * 100_000,
    "a float in base 60": "a: 1" + ":1" * 100_000 + ".0",
    "a number of a million digits": "a: 1" + "1" * 1_000_000,
    "lists nested without end": "[" * 50_000,
    "lists without end": "a: [" + "1, " * 1_000_000 + "1]",
    "a tab": "\ta: 1",
    "two documents": "a: 1\n---\nb: 2",
    "an unhashable key": "? [a]\n: 1",
    "control characters": "a: \x01",
}


@pytest.mark.parametrize("case", BAD_YAML)
def test_hostile_yaml_is_refused_in_one_line(case: str, place: Sandbox) -> None:
    message = place.refuse("<link name=\"${xacro.load_yaml('a.yaml')}\"/>", {"a.yaml": BAD_YAML[case]})
    assert "a.yaml" in message


def test_units_and_dots_of_yaml(place: Sandbox) -> None:
    yaml = "joint: {limit: {upper: !degrees 180, lower: !radians -pi/2, reach: !millimeters 3*100}, list: [{a: 1}]}"
    text = place.expand(
        '<xacro:property name="c" value="${xacro.load_yaml(\'a.yaml\')}"/>'
        "<a b=\"${c.joint.limit.upper - pi} ${c['joint']['limit']['lower'] + pi/2} ${c.joint.limit.reach}"
        ' ${c.joint.list[0].a}"/>',
        {"a.yaml": yaml},
    )
    assert '<a b="0.0 0.0 0.3 1"/>' in text


BLOCKS = {
    "an element of a namespace": "${A['**block'].ownerDocument}",
    "a symbol of a namespace": "${A.parent.root}",
    "an element's class": "${A['**block'].__class__}",
}


@pytest.mark.parametrize("case", BLOCKS)
def test_documents_are_not_reached_through_blocks(case: str, place: Sandbox) -> None:
    part = (
        '<robot xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:property name="block"><a/></xacro:property></robot>'
    )
    inside = f'<xacro:include filename="part.xacro" ns="A"/><link name="{BLOCKS[case]}"/>'
    assert "arm.xacro" in place.refuse(inside, {"part.xacro": part})


def test_a_refusal_stands_through_optional_includes(place: Sandbox) -> None:
    part = (
        '<robot xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:include filename="@SECRET" optional="true"/></robot>'
    )
    message = place.refuse('<xacro:include filename="part.xacro" optional="true"/>', {"part.xacro": part})
    assert "part.xacro: " in message
    assert "lies outside" in message
    assert "<a/>" in place.expand('<xacro:include filename="absent.xacro" optional="true"/><a/>')


@pytest.mark.parametrize("encoding", ["latin-1", "utf-8", "utf-8-sig", "utf-16"])
@pytest.mark.parametrize("declared", ["", ' encoding="iso-8859-1"', ' encoding="utf-8"'])
def test_files_of_any_origin(encoding: str, declared: str, tmp_path: Path) -> None:
    part = f'<?xml version="1.0"{declared}?>\r\n<robot {XMLNS}><!-- für Möbel -->\r\n<link name="stück"/></robot>'
    (tmp_path / "part.xacro").write_bytes(part.encode(encoding))
    inside = '<xacro:include filename="part.xacro"/><a b="${xacro.load_yaml(\'a.yaml\').größe}"/>'
    text = as_xacro(inside).replace('<?xml version="1.0"?>', f'<?xml version="1.0"{declared}?>\r\n<!-- für -->')
    (tmp_path / "arm.xacro").write_bytes(text.encode(encoding))
    (tmp_path / "a.yaml").write_bytes("größe: 3\r\n".encode(encoding))
    path = tmp_path / "arm.xacro"
    expanded, _ = expand_xacro(path, package_index(path))
    assert 'name="stück"' in expanded
    assert 'b="3"' in expanded


PARAMETERS = [
    ("a", {"a": "1"}),
    ("a:=2", {"a": "2"}),
    ("a:='x y' b=3", {"a": "x y", "b": "3"}),
    ("a:=${1 + 1} b:=^|${2 * 2}", {"a": "2", "b": "4"}),
    ("a:=${1 + 1}_${2 + 2}", {"a": "2_4"}),
    ("a:=$(arg side)", {"a": "left"}),
    ("a:=''", {"a": ""}),
]


@pytest.mark.parametrize(("params", "values"), PARAMETERS)
def test_defaults_of_parameters_are_read_as_by_xacro(params: str, values: dict[str, str], place: Sandbox) -> None:
    shown = "|".join(f"${{{name}}}" for name in values)
    call = '<xacro:m a="1"/>' if params == "a" else "<xacro:m/>"
    inside = (
        '<xacro:arg name="side" default="left"/>'
        f'<xacro:macro name="m" params="{params}"><x y="{shown}"/></xacro:macro>{call}'
    )
    assert f'<x y="{"|".join(values.values())}"/>' in place.expand(inside)
    plain = xacro.process_file(str(place.folder / "arm" / "arm.xacro"), verbosity=0).toxml()
    assert f'<x y="{"|".join(values.values())}"/>' in plain


def test_an_unknown_package_matters_only_where_a_file_of_it_is_opened(tmp_path: Path) -> None:
    path = write(tmp_path, as_xacro("<gazebo><a>$(find absent)/config.yaml</a></gazebo>"), "arm.xacro")
    arm = load_arm(path)
    assert [finding.code for finding in arm.findings] == ["package-not-found"]
    assert "$(find absent): package not found" in arm.findings[0].what


def test_packages_are_found_by_the_name_in_package_xml(tmp_path: Path) -> None:
    package(
        tmp_path / "ws" / "folder_of_another_name",
        "my_parts",
        {"p.xacro": f"<robot {XMLNS}><link name='extra'/></robot>"},
    )
    include = '<xacro:include filename="$(find my_parts)/p.xacro"/>'
    extra = joint("f", "upper", "extra", kind="fixed")
    text = as_xacro(include).replace("</robot>", f"{extra}</robot>")
    beside = write(package(tmp_path / "ws" / "arm", "arm"), text, "arm.xacro")
    assert "extra" in load_arm(beside).frame_names
    far = write(package(tmp_path / "a" / "b" / "c" / "d" / "e" / "f" / "g" / "h" / "i", "far"), text, "arm.xacro")
    with pytest.raises(DescriptionError, match="package 'my_parts' not found"):
        load_arm(far)
    assert "extra" in load_arm(far, package_dirs=[tmp_path / "ws"]).frame_names


@pytest.mark.parametrize("variable", ["ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH"])
def test_packages_of_the_environment(variable: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    inside = tmp_path / "prefix" / ("share/x" if variable == "AMENT_PREFIX_PATH" else "x")
    folder = package(inside, "named")
    monkeypatch.setenv(variable, os.pathsep.join(["nowhere", str(tmp_path / "prefix")]))
    (tmp_path / "file" / "deep").mkdir(parents=True)
    index = package_index(tmp_path / "file" / "deep" / "arm.urdf")
    assert index.find("named") == folder
    assert index.find("other") is None


def test_arguments_given_defaulted_and_misspelt(tmp_path: Path) -> None:
    text = as_xacro('<xacro:arg name="deck" default="one"/><xacro:property name="d" value="$(arg deck)"/>').replace(
        "</robot>", f'<link name="${{d}}"/>{joint("f", "base_link", "${d}", kind="fixed")}</robot>'
    )
    path = write(tmp_path, text, "arm.xacro")
    assert "one" in load_arm(path).frame_names
    assert "two" in load_arm(path, xacro_args={"deck": "two"}).frame_names
    with pytest.raises(InputError, match="no xacro argument 'dek'; closest: 'deck' \\(its arguments: deck\\)"):
        load_arm(path, xacro_args={"dek": "two"})
    with pytest.raises(DescriptionError, match="it is plain URDF and takes no xacro arguments"):
        load_arm(write(tmp_path, ARM), xacro_args={"deck": 1})


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

    def read(path: Path) -> str:
        states.append(seen())
        return path.read_text()

    before = seen()
    monkeypatch.setattr(hooks, "read_text", read)
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


def spent(place: Sandbox, inside: str) -> int:
    place.expand(inside)
    return place.spent


def test_a_macros_body_is_paid_for_at_each_call(place: Sandbox) -> None:
    macro = f'<xacro:macro name="m"><xacro:if value="0">{"<a/>" * 100}</xacro:if></xacro:macro>'
    once, thrice = (spent(place, macro + "<xacro:m/>" * calls) for calls in (1, 3))
    assert thrice - once > 2 * hooks.ELEMENT_COST * 100


def test_a_block_is_paid_for_each_time_it_is_inserted(place: Sandbox) -> None:
    block = f'<xacro:property name="b">{"<a/>" * 100}</xacro:property>'
    once, thrice = (spent(place, block + '<xacro:insert_block name="b"/>' * calls) for calls in (1, 3))
    assert thrice - once > 2 * hooks.ELEMENT_COST * 100


def test_siblings_are_paid_for_by_each_element_moved_among_them(place: Sandbox) -> None:
    moved, siblings = f'<xacro:if value="1">{"<a/>" * 1000}</xacro:if>', "<a/>" * 1000
    apart, among = (spent(place, text) for text in (f"{moved}<b>{siblings}</b>", f"<b/>{moved}{siblings}"))
    assert among - apart > 1000 * 1000 // hooks.SIBLINGS_PER_UNIT


def test_a_real_arm_takes_a_small_part_of_what_is_allowed(models: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    work = Work()
    monkeypatch.setattr(hooks, "Work", lambda: work)
    path = models / "ur_description" / "urdf" / "ur.urdf.xacro"
    expand_xacro(path, package_index(path), {"name": "ur", "ur_type": "ur5e"})
    assert MAX_WORK - work.left < MAX_WORK // 10


def test_deeply_nested_yaml_is_said_to_be_that(place: Sandbox) -> None:
    message = place.refuse("<link name=\"${xacro.load_yaml('a.yaml')}\"/>", {"a.yaml": "[" * 2000 + "]" * 2000})
    assert "the YAML is nested too deeply (in ${xacro.load_yaml('a.yaml')}); write it flatter" in message


def test_a_xacro_that_cannot_be_confined_is_not_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(own_xacro(), "resolve_macro")
    path = write(tmp_path, as_xacro(""), "arm.xacro")
    with pytest.raises(TwistarmError, match=r"has no resolve_macro and cannot be confined; pip install xacro==2.1.1"):
        expand_xacro(path, package_index(path))


def test_what_counts_as_xacro(tmp_path: Path) -> None:
    assert is_xacro(write(tmp_path, as_xacro('<xacro:property name="a" value="1"/>'), "hidden.urdf"))
    assert not is_xacro(write(tmp_path, as_xacro(""), "only_the_namespace.urdf"))
    assert not is_xacro(write(tmp_path, ARM, "plain.urdf"))
    late = as_xacro('<xacro:property name="a" value="1"/>').replace("<robot", f"<!--{' ' * 8000}--><robot")
    assert is_xacro(write(tmp_path, late, "late.urdf"))


def test_package_dirs_must_exist(tmp_path: Path) -> None:
    path = write(tmp_path, ARM)
    with pytest.raises(InputError, match="package_dirs: .*nowhere is not a folder"):
        load_arm(path, package_dirs=[tmp_path / "nowhere"])
