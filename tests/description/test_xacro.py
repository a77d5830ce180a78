"""xacro without ROS: the text of the xacro program, its errors with file and remedy, and nothing of the program's."""

from __future__ import annotations

import contextlib
import sys
from pathlib import Path
from xml.etree.ElementTree import canonicalize
from xml.sax.saxutils import quoteattr

import pytest
import xacro.substitution_args

from twistarm import load_arm
from twistarm.description.expansion import expand
from twistarm.description.expansion.expand import expand_xacro, is_xacro
from twistarm.description.packages import package_index
from twistarm.support.errors import DescriptionError, InputError, TwistarmError
from urdf_text import joint, write
from xacro_text import ARM, XMLNS, as_xacro, lay


def expanded(path: Path) -> str:
    return expand_xacro(path, package_index(path)).text


def by_the_program(path: Path) -> str:
    return str(xacro.process_file(str(path), verbosity=0).documentElement.toxml())


def robot(folder: Path, inside: str) -> Path:
    return write(
        folder, f'<robot name="r" {XMLNS} xmlns:cad="urn:cad" xmlns:sim="urn:sim">{inside}</robot>', "arm.xacro"
    )


MACRO = '<xacro:arg name="side" default="left"/><xacro:macro name="m" params="{}"><x y="{}"/></xacro:macro>{}'
SAME = {
    "an attribute before its namesake": '<link cad:name="x" name="l"/>',
    "one of another namespace": '<link name="l" cad:name="x" sim:name="y"/>',
    "a made element with attributes": '<xacro:element xacro:name="link" name="l"/>',
    "a made element of a prefix": '<xacro:element xacro:name="cad:part" name="p" xacro:on="1"/>',
    "a made attribute": '<link><xacro:attribute name="name" value="l"/></link>',
    "a made attribute of a prefix": '<link name="l"><xacro:attribute name="cad:name" value="x"/></link>',
    "a namespace declared inside": '<link xmlns:own="urn:own" own:name="x" name="l"/>',
    "one of a macro": '<xacro:macro name="m" xmlns:o="urn:o"><link o:name="x" name="l"/></xacro:macro><xacro:m/>',
    "an included namespace": '<xacro:include filename="part.xacro" ns="p"/><a b="${p.size + p.more.deep}"/>',
    "folders by wildcards": '<xacro:include filename="p?rts/*.xacro"/>',
    "several included files": '<xacro:include filename="p*t.xacro"/><xacro:m/>',
    "an optional file": '<xacro:include filename="absent.xacro" optional="true"/><a/>',
    "blocks": '<xacro:macro name="b" params="*one **all"><xacro:insert_block name="one"/>'
    '<xacro:insert_block name="all"/></xacro:macro><xacro:b><a/><c><d/><e/></c></xacro:b>',
    "scopes": '<xacro:macro name="s"><xacro:property name="v" value="${1 + 1}" scope="parent"/></xacro:macro>'
    '<xacro:s/><a b="${v}"/>',
    "conditions": '<xacro:if value="${1 &lt; 2}"><a/></xacro:if><xacro:unless value="false"><b/></xacro:unless>',
    "escaped dollars": '<a b="$${x} $$(y)" c="$"/>',
    "commands": '<xacro:arg name="n" default="2"/><a b="$(eval n * 3 + 1) $(arg n) $(optenv NONE a b)"/>',
    "units and dots of YAML": '<xacro:property name="c" value="${xacro.load_yaml(\'a.yaml\')}"/>'
    "<a b=\"${c.joint.upper - pi} ${c['joint']['lower'] + pi/2} ${c.joint.reach} ${c.list[0].a} ${c.list}\"/>",
    **{
        f"parameters {params}": MACRO.format(params, shown, call)
        for params, shown, call in (
            ("a", "${a}", '<xacro:m a="1"/>'),
            ("a:=2", "${a}", "<xacro:m/>"),
            ("a:='x y' b=3", "${a}|${b}", "<xacro:m/>"),
            ("a:=${1 + 1} b:=^|${2 * 2}", "${a}|${b}", "<xacro:m/>"),
            ("a:=${1 + 1}_${2 + 2}", "${a}", "<xacro:m/>"),
            ("a:=$(arg side)", "${a}", "<xacro:m/>"),
        )
    },
}

EXPRESSIONS = [
    "pi/2",
    "-x * 0.5 + 2**3 // 2 % 5 + (x << 2 | 1 & 3 ^ 5 >> 1) + ~x",
    "1./12 * x * (3 * 0.1**2 + 0.2**2)",
    "radians(90) + sin(pi) + atan2(1, 2) + sqrt(2) + math.factorial(5) + math.comb(5, 2) + math.prod([2, 3])",
    "x if name == 'left_arm' else -x",
    "name in ('left_arm', 'right_arm') and not x &lt; 2 or x != 3",
    "float(xyz.split()[1]) + x",
    "[str(i) + f for i, f in python.enumerate(fingers) if f.isupper()]",
    "dict(joint_1=0.0, joint_2=-1.57)['joint_2']",
    "{k: v * 2 for k, v in rates.items()}",
    "python.isinstance(fingers, list) and python.type(x) == python.int",
    "', '.join(sorted(fingers, key=lambda f: f.lower()))",
    "'%s_%02d %5.2f%%' % (name, x, rates['a'])",
    "f'{name}_{x:02d}'",
    "max(1, min(x, 2)) + round(2.567, 1) + len(fingers) + int('4') + python.abs(-2)",
    "python.sum([0.1] * 10) + python.sum(i * i for i in range(4))",
    "list(map(str, [1, 2])) + list(python.filter(None, [0, 1])) + list(python.zip(fingers, [1, 2]))",
    "name.replace('left', 'right').startswith('right')",
    "[*fingers, *['rf'] * 2, name[:4] + name[-1] + name[::2]]",
    "xacro.tokenize('a,b;c d')",
]
PROPERTIES = {
    "x": "3",
    "name": "left_arm",
    "xyz": "0 0.5 1",
    "fingers": "${['TH', 'ff']}",
    "rates": "${dict(a=1, b=2)}",
}


@pytest.mark.parametrize("inside", [*SAME.values()], ids=[*SAME])
def test_a_file_comes_out_as_from_xacro(inside: str, tmp_path: Path) -> None:
    part = '<xacro:property name="size" value="2"/><xacro:property name="more" value="${dict(deep=1)}"/>'
    macro = '<xacro:macro name="m"><link name="l${2 * 3}"/></xacro:macro>'
    write(
        tmp_path,
        f"<robot {XMLNS}>{part.replace('dict(deep=1)', 'xacro.dotify(dict(deep=1))')}{macro}</robot>",
        "part.xacro",
    )
    lay(tmp_path, {f"parts/{name}.xacro": f'<robot {XMLNS}><link name="{name}"/></robot>' for name in ("b", "a")})
    yaml = "joint: {upper: !degrees 180, lower: !radians -pi/2, reach: !millimeters 3*100}\nlist: [{a: 1}]\n"
    write(tmp_path, yaml, "a.yaml")
    path = robot(tmp_path, inside)
    assert canonicalize(expanded(path)) == canonicalize(by_the_program(path))


@pytest.mark.parametrize("expression", EXPRESSIONS)
def test_an_expression_means_what_it_means_in_xacro(expression: str, tmp_path: Path) -> None:
    properties = "".join(f'<xacro:property name="{name}" value="{value}"/>' for name, value in PROPERTIES.items())
    # Through an argument, so that braces are not xacro's.
    argument = f'<xacro:arg name="e" default={quoteattr(expression.replace("&lt;", "<"))}/>'
    path = robot(tmp_path, f'{argument}{properties}<a b="${{$(arg e)}}"/>')
    assert canonicalize(expanded(path)) == canonicalize(by_the_program(path))


@pytest.mark.parametrize("encoding", ["latin-1", "utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-32-be"])
@pytest.mark.parametrize("declared", ["", ' encoding="iso-8859-1"', ' encoding="utf-8"'])
def test_files_of_any_origin(encoding: str, declared: str, tmp_path: Path) -> None:
    part = f'<?xml version="1.0"{declared}?>\r\n<robot {XMLNS}><!-- für Möbel -->\r\n<link name="stück"/></robot>'
    (tmp_path / "part.xacro").write_bytes(part.encode(encoding))
    inside = '<xacro:include filename="part.xacro"/><a b="${xacro.load_yaml(\'a.yaml\').größe}"/>'
    text = as_xacro(inside).replace('<?xml version="1.0"?>', f'<?xml version="1.0"{declared}?>\r\n<!-- für -->')
    (tmp_path / "arm.xacro").write_bytes(text.encode(encoding))
    (tmp_path / "a.yaml").write_bytes("größe: 3\r\n".encode(encoding))
    assert 'name="stück"' in expanded(tmp_path / "arm.xacro")
    assert 'b="3"' in expanded(tmp_path / "arm.xacro")


def test_a_file_that_includes_itself_is_named_at_its_include(tmp_path: Path) -> None:
    write(tmp_path, f'<robot {XMLNS}>\n<xacro:include filename="arm.xacro"/></robot>', "part.xacro")
    with pytest.raises(DescriptionError) as refused:
        expanded(robot(tmp_path, '<xacro:include filename="part.xacro"/>'))
    (finding,) = refused.value.findings
    assert (finding.code, finding.place.element) == ("xacro-failed", "xacro:include")
    assert "part.xacro > arm.xacro" in finding.what


@pytest.mark.parametrize("name", [r"..\parts\a.xacro", "$(find parts)//a.xacro", r"$(find parts)\a.xacro"])
def test_backslashes_and_two_slashes_lead_where_slashes_do(name: str, tmp_path: Path) -> None:
    for folder in ("parts", "own/arm"):
        (tmp_path / folder).mkdir(parents=True)
    write(tmp_path / "parts", "<package><name>parts</name></package>", "package.xml")
    write(tmp_path / "own", "<package><name>own</name></package>", "package.xml")
    write(tmp_path / "parts", f'<robot {XMLNS}><link name="one"/></robot>', "a.xacro")
    path = robot(tmp_path / "own" / ("arm" if ".." not in name else ""), f'<xacro:include filename="{name}"/>')
    assert 'name="one"' in expanded(path)


FAILS = {
    '<xacro:include filename="$(find elsewhere)/a.xacro"/>': ("package-needed-not-found", "elsewhere"),
    '<xacro:include filename="absent.xacro"/>': ("xacro-failed", "absent.xacro"),
    '<xacro:arg name="size" default="2"/><link name="$(arg ar_model)"/>': ("xacro-arguments", "ar_model"),
    '<link name="$(arg name)"/><xacro:arg name="name" default="ur"/>': ("xacro-arguments", "'ur'"),
    "<link name=\"${xacro.arg('side')}\"/>": ("xacro-arguments", "side"),
    "<gazebo><sim:thing/></gazebo>": ("xml-malformed", "prefix"),
    "<gazebo xmlns:p='urn:x' xmlns:q='urn:x' p:a='1' q:a='2'/>": ("xml-malformed", "prefix"),
    "<robot": ("xml-malformed", ""),
    "<xacro:arm_of_mine/>": ("xacro-failed", "arm_of_mine"),
    '<link name="${nothing}"/>': ("xacro-failed", "'nothing'"),
    '<xacro:macro name="m"><xacro:m/></xacro:macro><xacro:m/>': ("xacro-failed", ""),
    '<xacro:include filename="arm.urdf.xacro"/>': ("xacro-failed", ""),
    '<xacro:arg name="h"/>': ("xacro-failed", "default="),
    '<xacro:macro name="m" params="a"><a b="${a}"/></xacro:macro><xacro:m a="1" sim="2"/>': ("xacro-failed", "xacro:m"),
    "${xacro.fatal('wrong', 'arm')}": ("xacro-failed", "wrong arm"),
    '<link name="${a"/>': ("xacro-failed", "${a"),
    '<xacro:macro name="arm"><link name="l"/></xacro:macro>': ("not-a-tree", ""),
}


@pytest.mark.parametrize("inside", FAILS)
def test_a_raw_error_becomes_a_line_with_the_file_and_the_culprit(inside: str, tmp_path: Path) -> None:
    path = write(tmp_path, as_xacro(inside).replace("</robot>", '<link name="alone"/></robot>'), "arm.urdf.xacro")
    code, culprit = FAILS[inside]
    with pytest.raises(DescriptionError) as caught:
        load_arm(path)
    assert [one.code for one in caught.value.findings] == [code]
    assert culprit in str(caught.value)
    assert "\n" not in str(caught.value)
    assert "\\n" not in str(caught.value)
    assert "arm.urdf.xacro" in str(caught.value)


def test_wildcards_match_in_a_folder_with_brackets(tmp_path: Path) -> None:
    lay(tmp_path, {"arm [2]/part.xacro": f'<robot {XMLNS}><link name="part"/></robot>'})
    assert "part" in expanded(robot(tmp_path / "arm [2]", '<xacro:include filename="p*.xacro"/>'))


def test_a_file_of_macros_alone_is_no_robot(tmp_path: Path) -> None:
    with pytest.raises(DescriptionError) as caught:
        load_arm(robot(tmp_path, '<xacro:macro name="arm"><link name="l"/></xacro:macro>'))
    assert [one.code for one in caught.value.findings] == ["no-robot"]


def test_a_fault_of_an_included_file_names_it_and_the_line(tmp_path: Path) -> None:
    write(tmp_path, f"<robot {XMLNS}>\n<link>\n</robot>", "part.xacro")
    with pytest.raises(DescriptionError) as caught:
        load_arm(write(tmp_path, as_xacro('<xacro:include filename="part.xacro"/>'), "arm.xacro"))
    (one,) = caught.value.findings
    assert (one.code, Path(one.place.file).name, one.place.line) == ("xml-malformed", "part.xacro", 3)


def test_arguments_given_defaulted_and_misspelt(tmp_path: Path) -> None:
    text = as_xacro('<xacro:arg name="deck" default="one"/><xacro:property name="d" value="$(arg deck)"/>').replace(
        "</robot>", f'<link name="${{d}}"/>{joint("f", "base_link", "${d}", kind="fixed")}</robot>'
    )
    path = write(tmp_path, text, "arm.xacro")
    assert "one" in load_arm(path).frame_names
    assert "two" in load_arm(path, xacro_args={"deck": "two"}).frame_names
    with pytest.raises(InputError, match="'dek'"):
        load_arm(path, xacro_args={"dek": "two"})
    with pytest.raises(DescriptionError) as caught:
        load_arm(write(tmp_path, ARM), xacro_args={"deck": 1})
    assert [one.code for one in caught.value.findings] == ["xacro-arguments"]


def test_only_a_variable_that_the_caller_names_is_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CANARY", "seen")
    path = write(tmp_path, as_xacro("").replace('name="tiny"', 'name="$(optenv CANARY arm)"'), "arm.xacro")
    kept = load_arm(path, tip="tool0")
    assert kept.name == "arm"
    assert "environment-kept" in [one.code for one in kept.findings]
    assert load_arm(path, tip="tool0", env_vars="CANARY").name == "seen"
    with pytest.raises(InputError, match="env_vars"):
        load_arm(path, env_vars=["CANARY=1"])
    required = write(tmp_path, as_xacro('<a b="$(env CANARY)"/>'), "required.xacro")
    with pytest.raises(DescriptionError):
        load_arm(required)
    assert load_arm(required, env_vars=["CANARY"]).n == 2


def test_what_counts_as_xacro(tmp_path: Path) -> None:
    assert is_xacro(write(tmp_path, as_xacro('<xacro:property name="a" value="1"/>'), "hidden.urdf"))
    assert not is_xacro(write(tmp_path, as_xacro(""), "only_the_namespace.urdf"))
    assert not is_xacro(write(tmp_path, ARM, "plain.urdf"))


def test_a_xacro_that_cannot_be_confined_is_not_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    other = expand._own_xacro()
    del other.safe_eval
    monkeypatch.setattr(expand, "_own_xacro", lambda: other)
    with pytest.raises(TwistarmError, match="no safe_eval"):
        expanded(write(tmp_path, as_xacro(""), "arm.xacro"))


@pytest.mark.parametrize(
    "inside",
    [
        "<link name=\"${xacro.warning('loud')}\"/>",
        '<xacro:include filename="absent.xacro"/>',
        "<link name=\"${'a'.format}\"/>",
        '<xacro:property name="a" value="${xacro.load_yaml(\'a.yaml\')}"/><link name="${a}"/>',
        '<xacro:property name="pi" value="3"/><!-- seen --> <xacro:if value="1"><link name="a"/></xacro:if>',
    ],
)
def test_the_program_s_xacro_is_left_as_it_was(inside: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    import yaml

    def state() -> tuple[object, ...]:
        modules = (xacro, xacro.substitution_args)
        names = [{key: value for key, value in vars(module).items() if key[:2] != "__"} for module in modules]
        return names, dict(xacro._global_symbols["math"]), dict(yaml.SafeLoader.yaml_constructors), sys.stderr

    write(tmp_path, "a: !degrees 3", "a.yaml")
    before = state()
    with contextlib.suppress(DescriptionError):
        expanded(write(tmp_path, as_xacro(inside), "arm.xacro"))
    assert state() == before
    assert capfd.readouterr() == ("", "")
