"""For every code of a finding the smallest inputs that raise it: files by name, and how they are loaded."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from urdf_text import joint, robot, two_joints

CAMERA = '<xacro:include filename="$(find camera)/camera.xacro"/><xacro:camera/>'
XACRO = 'xmlns:xacro="http://www.ros.org/wiki/xacro"'


@dataclass(frozen=True)
class Case:
    """Files (the first is the source), keywords of `load_arm`, and files of so many zero bytes."""

    files: Mapping[str, str]
    load: Mapping[str, Any] = field(default_factory=dict)
    sizes: Mapping[str, int] = field(default_factory=dict)


def urdf(text: str, **load: Any) -> Case:
    return Case({"arm.urdf": text}, load)


def xacro(body: str, *, files: Mapping[str, str] | None = None, **load: Any) -> Case:
    """A two-joint arm with `body` in front of its links."""
    text = two_joints().replace('<robot name="tiny">', f'<robot name="tiny" {XACRO}>{body}')
    return Case({"arm.urdf.xacro": text, **(files or {})}, load)


def mjcf(scenery: str, more: str = "") -> Case:
    """A two-joint arm on a floor, in MuJoCo's format."""
    arm = '<body name="tool0" pos="0 0 1"><joint name="b" axis="1 0 0"/><geom size="0.1"/></body>'
    arm = f'<body name="upper"><joint name="a" axis="0 1 0" range="-1 1"/><geom size="0.1"/>{arm}</body>'
    return Case({"arm.xml": f"<mujoco><worldbody>{scenery}{arm}</worldbody>{more}</mujoco>"})


def beside(name: str, text: str, *, arm: str | None = None, **load: Any) -> Case:
    return Case({"arm.urdf": arm or two_joints(), name: text}, load)


def toml(text: str, *, arm: str | None = None, **load: Any) -> Case:
    return Case({"arm.toml": f'source = "arm.urdf"\n{text}', "arm.urdf": arm or two_joints()}, load)


def limited(lower: str, upper: str, *, kind: str = "revolute", velocity: str = "1") -> Case:
    limit = f'<limit lower="{lower}" upper="{upper}" velocity="{velocity}" effort="1"/>'
    return urdf(two_joints(inside=limit, kind=kind))


def with_body(mass: str = "1", ixx: str = "0.01", com: str = "0 0 0") -> Case:
    inertia = f'ixx="{ixx}" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"'
    body = f'<inertial><origin xyz="{com}"/><mass value="{mass}"/><inertia {inertia}/></inertial>'
    return urdf(two_joints().replace('<link name="upper"/>', f'<link name="upper">{body}</link>'))


def with_balls(*centres: str) -> str:
    """A two-joint arm that bends about y, with a ball of radius 0.05 m on each link."""
    text = two_joints(inside='<axis xyz="0 1 0"/>')
    for link, xyz in zip(("base_link", "upper", "tool0"), centres, strict=True):
        shape = f'<collision><origin xyz="{xyz}"/><geometry><sphere radius="0.05"/></geometry></collision>'
        text = text.replace(f'<link name="{link}"/>', f'<link name="{link}">{shape}</link>')
    return text


def with_mesh(content: str | None, scale: str = "1 1 1", size: int | None = None) -> Case:
    """A mesh on the link `upper`; `size`: that many bytes of nothing instead."""
    shape = f'<visual><geometry><mesh filename="part.stl" scale="{scale}"/></geometry></visual>'
    text = two_joints().replace('<link name="upper"/>', f'<link name="upper">{shape}</link>')
    files = {"arm.urdf": text} | ({} if content is None else {"part.stl": content})
    return Case(files, sizes={} if size is None else {"part.stl": size})


def triangle(size: float) -> str:
    """An ASCII STL of one triangle with legs of that length."""
    corners = (f"{size} 0 0", f"0 {size} 0", "0 0 0")
    loop = "".join(f"vertex {corner}\n" for corner in corners)
    return f"solid s\nfacet normal 0 0 1\nouter loop\n{loop}endloop\nendfacet\nendsolid s\n"


def chain(*axes: str, xyz: str = "0 0 0.5", rpy: str = "0 0 0", tip: str = "tool0", kind: str = "revolute") -> str:
    """Turning joints j0, j1, … about these axes, and a fixed tool beyond the last."""
    links = tuple(f"l{i}" for i in range(len(axes) + 1))
    parts = [
        joint(f"j{i}", links[i], links[i + 1], kind=kind, inside=f'<axis xyz="{axis}"/>', xyz=xyz, rpy=rpy)
        for i, axis in enumerate(axes)
    ]
    return robot(*parts, joint("mount", links[-1], tip, kind="fixed"), links=(*links, tip))


def srdf(inside: str = "", name: str = "tiny") -> str:
    return f'<robot name="{name}">{inside}</robot>'


def coloured(name: str, *rgba: str) -> str:
    """Boxes on the link `upper`, each with a material of these colours."""
    box = '<geometry><box size="1 1 1"/></geometry>'
    shapes = "".join(f'<visual>{box}<material {name}><color rgba="{one}"/></material></visual>' for one in rgba)
    return two_joints().replace('<link name="upper"/>', f'<link name="upper">{shapes}</link>')


PLANAR = joint("p", "base_link", "upper", kind="planar", inside='<limit velocity="1" effort="1"/>')
LOOSE = joint("b", "upper", "tool0")
POINTER = "version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 9\n"
STATES = '<group name="g"><chain base_link="base_link" tip_link="tool0"/></group><group_state name="s" group="g">'
FOUR = chain("0 0 1", "0 1 0", "0 1 0", "1 0 0")
PLACEHOLDER = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
SOFT = '<safety_controller soft_lower_limit="{}" soft_upper_limit="{}" k_velocity="10"/>'
MIMIC = '<mimic joint="a" multiplier="{}"/>'


def follower(mimic: str, limit: str = '<limit lower="-1" upper="1" velocity="1" effort="1"/>') -> str:
    """Joint b follows."""
    return robot(joint("a", "base_link", "upper"), joint("b", "upper", "tool0", inside=mimic + limit))


def controlled(inside: str) -> str:
    """A two-joint arm with a command of position for joint a."""
    command = f'<joint name="a"><command_interface name="position">{inside}</command_interface></joint>'
    return two_joints().replace("</robot>", f'<ros2_control name="c" type="system">{command}</ros2_control></robot>')


CASES: dict[str, Case] = {
    # the file
    "file-unreadable: none": Case({"arm.toml": 'source = "gone.urdf"'}),
    "file-unreadable": xacro('<xacro:include filename="folder/."/>', files={"folder/x.txt": ""}),
    "companion-unusable: arm.toml": toml("speed = 3"),
    "xml-malformed": urdf("<robot><link></robot>"),
    "xml-malformed: a document type": urdf('<!DOCTYPE robot [<!ENTITY x "y">]><robot name="r"/>'),
    "no-robot": urdf('<robot name="empty"/>'),
    # MJCF
    "mjcf-unusable": mjcf('<include file="lost.xml"/>'),
    "mjcf-scenery-left-out": mjcf('<geom type="plane" size="1 1 1"/>'),
    "mjcf-part-not-read": mjcf('<composite prefix="rope" type="cable" count="3 1 1"/>'),
    "mjcf-gravity": mjcf("", '<option gravity="0 -9.81 0"/>'),
    "mjcf-loop-open": mjcf("", '<equality><connect body1="upper" body2="tool0" anchor="0 0 0"/></equality>'),
    "xml-malformed: a comment first": urdf('<!-- mine --><?xml version="1.0"?><robot name="r"/>'),
    "xml-malformed: a digit after the colon": xacro("<xacro:2dof_control/>"),
    "unit-doubtful: MJCF": Case({"arm.xml": mjcf("").files["arm.xml"].replace("-1 1", "-2.9 2.9")}),
    # the tree
    "word-unread: a version": urdf(two_joints().replace('<robot ', '<robot version="3.0" ')),
    "name-unusable: none": urdf(two_joints().replace('<link name="upper"/>', '<link name="upper"/><link/>')),
    "name-unusable: twice": urdf(robot(joint("a", "base_link", "upper"), joint("a", "upper", "tool0"))),
    "not-a-tree: no child": urdf(two_joints().replace('<child link="upper"/>', "")),
    "not-a-tree: undefined": urdf(robot(joint("a", "base_link", "uper"), LOOSE)),
    "not-a-tree: two parents": urdf(robot(joint("a", "base_link", "tool0"), LOOSE, joint("c", "base_link", "upper"))),
    "not-a-tree: two roots": urdf(robot(joint("a", "base_link", "upper"))),
    "not-a-tree: a circle": urdf(
        robot(joint("a", "base_link", "upper"), joint("b", "x", "y"), joint("c", "y", "x"),
              links=("base_link", "upper", "x", "y"))
    ),
    "too-large: deep": urdf(chain(*["0 0 1"] * 1200)),
    "too-large: links": urdf(robot(links=("a",) * 4001)),
    "name-unusable: long": urdf(robot(links=("a" * 501,))),
    "too-large: joints": urdf(chain(*["0 0 1"] * 260)),
    # joints
    "joint-type-unknown": urdf(two_joints(kind="rotary")),
    "number-malformed: origin": urdf(two_joints(xyz="0 0")),
    "number-malformed: axis": urdf(two_joints(inside='<axis xyz="0 z 1"/>')),
    "number-malformed: axis 0": urdf(two_joints(inside='<axis xyz="0 0 0"/>')),
    "word-unread": urdf(two_joints(inside='<mimic joint="b" multiplyer="-2"/>')),
    "unit-doubtful: rpy": urdf(two_joints(rpy="90 0 0")),
    "word-unread: no name": urdf(two_joints().replace(' name="tiny"', "")),
    "axis-not-unit": urdf(two_joints(inside='<axis xyz="0 0 2"/>')),
    "number-malformed: limit": urdf(two_joints(inside='<limit lower="pi" upper="1" velocity="1" effort="1"/>')),
    "limits-swapped": limited("1", "-1"),
    "limit-incomplete": urdf(two_joints(inside='<limit lower="-1" velocity="1" effort="1"/>')),
    "limits-adjusted: soft": urdf(two_joints(inside=SOFT.format(-0.5, 0.5))),
    "outside-limits: soft": urdf(two_joints(inside=SOFT.format(2, 3))),
    "limit-incomplete: equal": limited("0.5", "0.5"),
    "rate-not-given: velocity": limited("-1", "1", velocity="0"),
    "rate-not-given: effort": urdf(two_joints(inside='<limit lower="-1" upper="1" velocity="1" effort="-1"/>')),
    "number-malformed: mimic": urdf(follower('<mimic joint="a" multiplier="half"/>')),
    "mimic-unusable: no master": urdf(follower('<mimic joint="aa"/>')),
    "mimic-unusable: a planar master": urdf(robot(PLANAR, joint("b", "upper", "tool0", inside='<mimic joint="p"/>'))),
    "mimic-unusable: a planar follower": urdf(
        robot(joint("p", "base_link", "upper", kind="planar", inside='<mimic joint="b"/>'), LOOSE)
    ),
    "limits-adjusted: planar": urdf(robot(PLANAR, LOOSE)),
    "mimic-unusable: a circle": urdf(
        robot(joint("a", "base_link", "upper", inside='<mimic joint="b"/>'),
              joint("b", "upper", "tool0", inside='<mimic joint="a"/>'))
    ),
    "limits-adjusted: narrowed": urdf(follower(MIMIC.format(2))),
    "outside-limits: follower": urdf(follower(MIMIC.format(1), '<limit lower="0" upper="0" velocity="1" effort="1"/>')),
    "outside-limits: locked": urdf(two_joints(), locked_joints={"a": 2.0}),
    # the chain
    "no-tip": urdf(
        robot(
            joint("a", "base_link", "upper"), joint("b", "upper", "gripper"), joint("c", "upper", "probe"),
            links=("base_link", "upper", "gripper", "probe"),
        )
    ),
    "no-chain: base below tip": urdf(two_joints(), base="tool0", tip="upper"),
    "no-chain: nothing moves": urdf(two_joints(), tip="base_link"),
    "no-chain: floating": urdf(two_joints(kind="floating")),
    "companion-unusable: tool": toml('[tool]\nname = "upper"\n'),
    "companion-unusable: pose": toml("[poses.ready]\na = 0.0\n"),
    "companion-unusable: limits": beside("limits.yaml", "{", limits="limits.yaml"),
    # what stands beside
    "srdf-found": beside("arm.srdf", srdf('<group name="g"><chain base_link="base_link" tip_link="tool0"/></group>')),
    "companion-not-used: SRDF, several": Case({"arm.urdf": two_joints(), "one.srdf": srdf(), "two.srdf": srdf()}),
    "companion-doubtful: SRDF, broken": beside("arm.srdf", "<robot"),
    "ready-named": beside(
        "arm.srdf",
        srdf(STATES.replace('"s"', '"Home"') + '<joint name="a" value="0"/><joint name="b" value="0"/></group_state>'),
    ),
    "companion-doubtful: SRDF, passive": beside("arm.srdf", srdf('<passive_joint name="a"/>')),
    "companion-doubtful: ros2_control": urdf(controlled('<param name="max">0.5</param>')),
    "companion-doubtful: ros2_control, unresolved": urdf(controlled('<param name="max">${limit}</param>')),
    "companion-doubtful: ros2_control, off": urdf(controlled('<limits enable="false"/>')),
    # what hangs on the links
    "mesh-missing": with_mesh(None),
    "bad-geometry": urdf(
        two_joints().replace(
            '<link name="upper"/>', '<link name="upper"><visual><geometry><sphere/></geometry></visual></link>'
        )
    ),
    "bad-geometry: two colours": urdf(coloured('name="m"', "1 0 0 1", "0 0 1 1")),
    "bad-geometry: colour": urdf(coloured('name="m"', "255 128 0 1")),
    "inertial-unusable": with_body(mass="1kg"),
    "inertial-unusable: an entry": Case({"arm.urdf": with_body().files["arm.urdf"].replace(' iyy="0.01"', "")}),
    "word-unread: of a link": Case({"arm.urdf": with_body().files["arm.urdf"].replace("iyy=", "yy=")}),
    "word-unread: two of one": Case({"arm.urdf": with_body().files["arm.urdf"].replace("<mass", "<mass/><mass")}),
    "word-unread: a material": urdf(coloured("", "1 0 0 1")),
    "word-unread: no prefix": xacro('<xacro:macro name="hand"><gazebo/></xacro:macro><hand/>'),
    "word-unread: no prefix in a link": xacro(
        '<xacro:macro name="heavy"><mass value="1"/></xacro:macro><link name="floor"><heavy/></link>'
        + joint("f", "floor", "base_link", kind="fixed")
    ),
    # packages and xacro
    "package-not-found": xacro('<gazebo file="$(find nowhere)/x"/>'),
    "package-without-manifest": xacro('<gazebo file="$(find copied)/x"/>', files={"copied/urdf/x.urdf": ""}),
    "environment-kept": xacro('<gazebo h="$(optenv HOME)"/>'),
    "package-left-out": xacro(CAMERA, ignore_packages=["camera"]),
    "package-needed-not-found": xacro('<xacro:include filename="$(find nowhere)/x.xacro"/>'),
    "xacro-arguments: missing": xacro('<xacro:property name="h" value="$(arg height)"/><gazebo h="${h}"/>'),
    "xacro-arguments: unknown": urdf(two_joints(), xacro_args={"colour": "red"}),
    "xacro-failed": xacro('<gazebo h="${height}"/>'),
    "xacro-failed: recursion": xacro('<xacro:macro name="m"><xacro:m/></xacro:macro><xacro:m/>'),
    "xacro-expression-refused": xacro('<gazebo h="${().__class__}"/>'),
    "file-outside-packages": xacro('<xacro:include filename="/etc/hostname"/>'),
    "file-unreadable: too large": Case(
        xacro('<xacro:include filename="big.xacro"/>').files, sizes={"big.xacro": 30_000_000}
    ),
    # limits
    "unit-doubtful: degrees": limited("-170", "170"),
    "unit-doubtful: millimetres": limited("0", "400", kind="prismatic"),
    "limit-incomplete: nearly": limited("-0.001", "0.001"),
    "unit-doubtful: velocity": limited("-1", "1", velocity="180"),
    "unit-doubtful: reach": urdf(chain("0 0 1", "0 1 0", xyz="300 0 0")),
    # postures
    "zero-outside-limits": limited("0.5", "1"),
    "home-singular": urdf(chain("0 1 0", "0 1 0", "0 1 0")),
    "links-collide": toml("[poses.ready]\na = 0\nb = 0\n", arm=with_balls("0 0 1", "0 0 0", "0 0 0")),
    "ready-singular": Case(
        {
            "arm.toml": 'source = "arm.urdf"\n[poses.ready]\nj0 = 0.0\nj1 = 0.001\nj2 = 0.0\n',
            "arm.urdf": chain("0 1 0", "0 1 0", "0 1 0"),
        }
    ),
    # what the arm is able to do
    "cannot-move": urdf(chain("0 0 1", "0 0 1", xyz="0.5 0 0")),
    "cannot-turn": urdf(chain("0 0 1", "0 0 1", xyz="0.5 0 0")),
    "cannot-turn-in-place": urdf(FOUR),
    "joint-without-effect": urdf(
        robot(
            joint("a", "base_link", "upper", xyz="0 0 0"),
            joint("b", "upper", "fore", xyz="0 0 0", inside=MIMIC.format(-1)),
            joint("c", "fore", "tool0"),
            links=("base_link", "upper", "fore", "tool0"),
        )
    ),
    "off-the-chain: joint": urdf(
        robot(
            joint("a", "base_link", "tool0"), joint("finger", "tool0", "jaw"),
            links=("base_link", "tool0", "jaw"),
        )
    ),
    # axes
    "axes-almost-exact": urdf(chain("0 0 1", "0 0 1", rpy="1.5708 0 0")),
    "axes-almost-exact: closed form": urdf(chain("0 0 1", "0 1 0", "0 1 0", "0 1 0", "0 0 1", "0 1 0", rpy="1e-5 0 0")),
    # the tool
    "tool-frame-missing": urdf(two_joints().replace("tool0", "flange")),
    "several-tips": urdf(
        robot(
            joint("a", "base_link", "tool0"), joint("eye", "base_link", "camera", kind="fixed"),
            links=("base_link", "tool0", "camera"),
        )
    ),
    # bodies
    "mass-missing": urdf(with_balls("0 0 0", "0 0 0.2", "0 0 0.2")),
    "mass-missing: tiny": with_body(mass="1e-9"),
    "inertia-implausible: mass": with_body(mass="1500"),
    "inertia-implausible: moments": with_body(ixx="0.03"),
    "inertia-implausible": with_body(mass="0.0001"),
    "mass-missing: all the same": urdf(
        two_joints().replace('"/><link', f'">{PLACEHOLDER}</link><link').replace(
            'name="tool0"/>', f'name="tool0">{PLACEHOLDER}</link>', 1
        )
    ),
    "inertia-implausible: centre": with_body(com="0 0 250"),
    # meshes
    "unit-doubtful: large mesh": with_mesh(triangle(300.0)),
    "unit-doubtful: small mesh": with_mesh(triangle(0.3), scale="0.001 0.001 0.001"),
    "mesh-unreadable: LFS pointer": with_mesh(POINTER),
    "mesh-missing: elsewhere": Case(
        {name: text.replace("part.stl", "/elsewhere/part.stl") for name, text in with_mesh(triangle(0.3)).files.items()}
    ),
    "mesh-unreadable: a page": with_mesh("<!DOCTYPE html><html></html>" + " " * 200),
    "mesh-unreadable: an archive": with_mesh("PK\3\4" + " " * 200),
    "mesh-unreadable: an OBJ": with_mesh("# a part\nv 0 0 0\n" * 20),
    "file-unreadable: a pointer": urdf(POINTER),
    "mesh-unreadable: commas": with_mesh(triangle(0.3).replace(".", ",")),
    "mesh-unreadable": with_mesh("solid nothing\nendsolid nothing\n"),
}  # fmt: skip
"""By the code, and a word where several inputs raise it."""

# No input raises these: they are about a fault, ours or Pinocchio's, or about what is missing here.
FAULTS = ("engines-disagree", "not-compared")
