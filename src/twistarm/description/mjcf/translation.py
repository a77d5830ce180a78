"""MJCF to a URDF text: bodies and sites become links, and joints keep their names."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ...support.checks import Array
from ...support.errors import listed
from ...theory.rotations import from_quaternion_wxyz, to_rpy
from ...theory.screws import exp
from ..companions.srdf import GroupState, Semantics
from ..document import Reading, floats
from ..inertial import Body
from ..planar import free_name
from ..writing import add_joint, add_mimic, add_origin
from .document import ACTUATORS, MAIN, Attributes, Mjcf, read_mjcf
from .shapes import Shapes, explicit_body, inertial_of, several

ROOT = "world"
"""MuJoCo's name of the body that carries all others."""

TURNS = ("_rz", "_ry", "_rx")
"""Endings of the coordinates of a ball, in the order of `ArmBuilder.spherical`."""

SHOWN = 8
"""Most things in one finding."""

_NOT_READ = ("composite", "flexcomp", "attach", "replicate", "plugin")

_Part = tuple[ET.Element, Array, str]
"""An element of a body, its frame (4, 4) in the body's, and the class around it."""


class Translated(NamedTuple):
    """The URDF text, the MJCF as one text in which every body and joint has a name, and its poses and pairs."""

    urdf: str
    mjcf: str
    semantics: Semantics | None


class _Moving(NamedTuple):
    """A hinge or slide that was written: its element, its frame (4, 4), its twist (6,), its value at rest."""

    element: ET.Element
    origin: Array
    twist: Array
    rest: float


def translated(root: ET.Element, reading: Reading) -> Translated:
    """Translate an MJCF. What URDF has no word for is left out, with findings in `reading`.

    A joint that does not turn about its body's origin, or is not 0 at rest, gets a link between. A ball becomes three
    turns, the Euler angles ZYX. Free bodies without joints are left out, and other free bodies stand still. Raises
    DescriptionError for an unusable element.
    """
    writer = _Writer(read_mjcf(root, reading))
    writer.inside(writer.mjcf.root.findall("worldbody"), ROOT, MAIN)
    writer.couple()
    semantics = writer.semantics()
    writer.note(reading)
    for link in writer.robot.findall("link"):
        link.extend(writer.contents.get(link.get("name", ""), ()))
    return Translated(
        ET.tostring(writer.robot, encoding="unicode"), ET.tostring(writer.mjcf.root, encoding="unicode"), semantics
    )


class _Writer:
    """The URDF as far as it is written. `layout` has the joints of each entry of a keyframe's qpos, and its length."""

    def __init__(self, mjcf: Mjcf) -> None:
        self.mjcf = mjcf
        self.robot = ET.Element("robot", name=mjcf.root.get("model") or mjcf.readings[0].path.stem)
        ET.SubElement(self.robot, "link", name=ROOT)
        self.contents: dict[str, list[ET.Element]] = {}
        self._shapes = Shapes(mjcf)
        self._links = {ROOT, *(body.get("name", "") for body in mjcf.root.iter("body"))}
        self._joints = {joint.get("name", "") for tag in ("joint", "freejoint") for joint in mjcf.root.iter(tag)}
        self._moving: dict[str, _Moving] = {}
        self._layout: list[tuple[tuple[str, ...], int]] = []
        self._pairs: set[tuple[str, str]] = set()
        self._scenery: dict[str, None] = {}
        self._not_read: dict[str, None] = {}
        self._loose: dict[str, None] = {}
        self._efforts: dict[str, float] = {}
        for actuator in mjcf.each("actuator", *ACTUATORS):
            with self._told(actuator):
                self._note_effort(actuator.tag, mjcf.attributes(actuator))

    # -- bodies ------------------------------------------------------------------------------------------------------

    def inside(self, elements: list[ET.Element], link: str, childclass: str) -> None:
        """Write what the elements of one body hold."""
        parts = [part for element in elements for part in self._parts(element, np.eye(4), childclass)]
        contents, rule = self.contents.setdefault(link, []), self.mjcf.compiler.get("inertiafromgeom", "auto")
        bodies: list[Body] = []
        from_geoms = rule == "true" or (rule == "auto" and all(part.tag != "inertial" for part, *_ in parts))
        for part, frame, around in parts:
            with self._told(part):
                if part.tag == "geom":
                    given = self.mjcf.attributes(part, around)
                    shapes, body = self._shapes.of(given, frame)
                    contents += shapes
                    bodies += [body] if body and from_geoms else []
                    self._note_geom(given, link, weighed=body is not None or not from_geoms)
                elif part.tag == "inertial" and not from_geoms:
                    bodies.append(explicit_body(dict(part.attrib), self.mjcf))
                elif part.tag == "site" and part.get("name"):
                    name, pose = part.get("name", ""), self.mjcf.pose(self.mjcf.attributes(part, around))
                    part.set("name", free_name(f"{name}_site" if name in self._links else name, self._links))
                    self._fixed(part.get("name", ""), link, frame @ pose)
                elif part.tag in _NOT_READ:
                    self._not_read[f"<{part.tag}> {part.get('name') or part.get('prefix', '')}".strip()] = None
        contents += inertial_of(bodies) if link != ROOT else []
        for part, frame, around in parts:
            if part.tag == "body":
                self._body(part, link, frame, around)

    def _note_geom(self, given: Attributes, link: str, *, weighed: bool) -> None:
        """Note a shape that is not drawn, and a mesh whose mass is not known."""
        kind = given.get("type", "mesh" if "mesh" in given else "sphere")
        if kind == "mesh" and not weighed and link != ROOT and given.get("mass") != "0":
            self._not_read[f"the mass of a mesh of {link!r}"] = None
        if kind in ("plane", "hfield", "ellipsoid", "sdf"):
            self._scenery[f"a shape of type {kind}"] = None

    def _parts(self, element: ET.Element, frame: Array, childclass: str) -> Iterator[_Part]:
        """The elements of a body, also those in frames of MJCF."""
        around = element.get("childclass", childclass)
        for part in element:
            if part.tag == "frame":
                with self._told(part):
                    inner = frame @ self.mjcf.pose(dict(part.attrib))
                yield from self._parts(part, inner, around)
            else:
                yield part, frame, around

    def _body(self, body: ET.Element, parent: str, frame: Array, childclass: str) -> None:
        name = body.get("name") or free_name(f"{parent}_body", self._links)
        body.set("name", name)
        with self._told(body):
            g = frame @ self.mjcf.pose(dict(body.attrib))
        found = [
            (part, self.mjcf.attributes(part, around), local)
            for part, local, around in self._parts(body, np.eye(4), childclass)
            if part.tag in ("joint", "freejoint")
        ]
        if any(part.tag == "freejoint" or given.get("type") == "free" for part, given, _ in found):
            self._layout.append(((), 7))
            if len(list(body.iter("joint"))) == sum(part.tag == "joint" for part, *_ in found):
                self._scenery[f"the free body {name!r}"] = None
                return
            self._scenery[f"the free joint of {name!r}, which stands where the file puts it"] = None
            found = []
        link = parent
        for i, (joint, given, local) in enumerate(found):
            with self._told(joint):
                link, g = self._joint(joint, given, link, g, local, name, last=i == len(found) - 1)
        if link not in (parent, name):  # MuJoCo lets a body and its parent overlap
            self._pairs.add((min(parent, name), max(parent, name)))
        if link != name:
            self._fixed(name, link, g)
        self.inside([body], name, childclass)

    def _fixed(self, name: str, parent: str, g: Array) -> None:
        add_joint(self.robot, free_name(f"{name}_fixed", self._joints), "fixed", (parent, name), g)

    def _joint(
        self, joint: ET.Element, given: Attributes, link: str, g: Array, local: Array, body: str, *, last: bool
    ) -> tuple[str, Array]:
        """Write a joint on `link`, in the body's frame `g`. Return the link beyond, and the body's frame in it."""
        name = joint.get("name") or free_name(f"{body}_joint", self._joints)
        joint.set("name", name)
        kind = given.get("type", "hinge")
        if kind not in ("hinge", "slide", "ball"):
            raise ValueError(f"joint type {kind[:60]!r} is none of hinge, slide, ball, free")
        origin, back = np.eye(4), np.eye(4)
        origin[:3, 3] = local[:3, :3] @ floats(given.get("pos", "0 0 0"), 3) + local[:3, 3]
        back[:3, 3] = -origin[:3, 3]
        axis = local[:3, :3] @ floats(given.get("axis", "0 0 1"), 3)
        axis = axis / max(float(np.linalg.norm(axis)), 1e-300)
        if kind == "ball":
            turns = [(name + ending, "continuous", axis) for ending, axis in zip(TURNS, np.eye(3)[::-1], strict=True)]
            self._layout.append((tuple(turn for turn, *_ in turns), 4))
            limit, rest, twist = {}, 0.0, np.zeros(6)
        else:
            (rest,) = floats(given.get("ref", "0"), 1)
            rest = self.mjcf.angle(rest) if kind == "hinge" else rest
            twist = np.concatenate([np.zeros(3), axis] if kind == "hinge" else [axis, np.zeros(3)])
            limit = self._limit(name, kind, given)
            turning = "revolute" if "lower" in limit else "continuous"
            turns = [(name, turning if kind == "hinge" else "prismatic", axis)]
            self._layout.append(((name,), 1))
        back = exp(twist, -rest) @ back
        ends = [link, *(f"{turn}_link" for turn, *_ in turns)]
        ends[1:] = [free_name(end, self._links) for end in ends[1:-1]] + [
            body if last and np.array_equal(back, np.eye(4)) else free_name(ends[-1], self._links)
        ]
        place = g @ origin
        for (turn, sort, along), pair in zip(turns, pairwise(ends), strict=True):
            element = add_joint(self.robot, turn, sort, pair, place, along, limit)
            if kind != "ball":
                self._moving[name] = _Moving(element, place, twist, rest)
            place = np.eye(4)
        return ends[-1], back

    def _limit(self, name: str, kind: str, given: Attributes) -> dict[str, float]:
        """The numbers of `<limit>`. MJCF has no limits of velocity; 0 is read as "not given"."""
        lower, upper = (
            self.mjcf.angle(bound) if kind == "hinge" else bound for bound in floats(given.get("range", "0 0"), 2)
        )
        said, automatic = given.get("limited", "auto"), self.mjcf.compiler.get("autolimits", "true") == "true"
        limited = said == "true" or (said == "auto" and automatic and (lower, upper) != (0.0, 0.0))
        bounds = {"lower": lower, "upper": upper} if limited else {}
        if not limited and kind == "slide":
            bounds = {"lower": -np.inf, "upper": np.inf}
        effort = self._efforts.get(name, 0.0)
        if "actuatorfrcrange" in given and given.get("actuatorfrclimited") != "false":
            effort = max(map(abs, floats(given["actuatorfrcrange"], 2)))
        return {**bounds, "velocity": 0.0, "effort": effort}

    def _note_effort(self, tag: str, given: Attributes) -> None:
        """Keep the largest effort that an actuator brings to its joint."""
        words = given.get("forcerange") if given.get("forcelimited") != "false" else None
        words = words or (given.get("ctrlrange") if tag == "motor" else None)
        if words and "joint" in given:
            force, gear = max(map(abs, floats(words, 2))), several(given.get("gear", "1"))
            self._efforts[given["joint"]] = max(self._efforts.get(given["joint"], 0.0), force * abs((gear or [1.0])[0]))

    # -- what stands beside the bodies -------------------------------------------------------------------------------

    def couple(self) -> None:
        """Make followers of joints by `equality`: q₁ − rest₁ = a₀ + a₁ (q₂ − rest₂)."""
        for element in (part for section in self.mjcf.root.findall("equality") for part in section):
            if element.get("active") == "false":
                continue
            first, second = element.get("joint1", ""), element.get("joint2", "")
            with self._told(element):
                given = several(element.get("polycoef", ""))
            a0, a1, *higher = [*given, *(0.0, 1.0, 0.0, 0.0, 0.0)[len(given) :]]
            follower, master = self._moving.get(first), self._moving.get(second)
            if element.tag != "joint" or follower is None or any(higher) or (second and master is None):
                self._loose[f"<{element.tag}> {element.get('name') or listed(filter(None, (first, second)))}"] = None
            elif master is None:  # the joint stands still
                follower.element.set("type", "fixed")
                follower.element[:] = [part for part in follower.element if part.tag in ("parent", "child")]
                add_origin(follower.element, follower.origin @ exp(follower.twist, follower.rest + a0))
                del self._moving[first]
            else:
                add_mimic(follower.element, second, a1, follower.rest + a0 - a1 * master.rest)
                del self._moving[first]

    def semantics(self) -> Semantics | None:
        """The keyframes as named poses, and the pairs of `contact/exclude`; None if there are none."""
        for exclude in self.mjcf.each("contact", "exclude"):
            one, other = sorted((exclude.get("body1", ""), exclude.get("body2", "")))
            self._pairs.add((one, other))
        states = []
        for key in self.mjcf.each("keyframe", "key"):
            with self._told(key):
                if key.get("name") and "qpos" in key.attrib and (values := self._values(key)):
                    states.append(GroupState(key.get("name", ""), "", values))
        if not states and not self._pairs:
            return None
        path = self.mjcf.readings[0].path
        return Semantics(path, self.robot.get("name", ""), states=tuple(states), disabled=frozenset(self._pairs))

    def _values(self, key: ET.Element) -> dict[str, float]:
        """A keyframe's value of each joint. Empty if it has another length than the model."""
        qpos, length = several(key.get("qpos", "")), sum(length for _, length in self._layout)
        if len(qpos) != length:
            self._not_read[f"the keyframe {key.get('name')!r}, which has {len(qpos)} numbers for {length}"] = None
            return {}
        values: dict[str, float] = {}
        for names, length in self._layout:
            numbers, qpos = qpos[:length], qpos[length:]
            if length == 4:
                numbers = to_rpy(from_quaternion_wxyz(numbers))[::-1].tolist()
            values |= dict(zip(names, numbers, strict=False))
        return values

    def note(self, reading: Reading) -> None:
        """Add a finding for each kind of thing that URDF does not have."""
        if self.mjcf.root.find("tendon") is not None:
            self._scenery["its tendons"] = None
        if self.mjcf.root.find("deformable") is not None:
            self._scenery["its deformable bodies"] = None
        told = [
            ("mjcf-scenery-left-out", self._scenery, "left out", "describe obstacles in a scene.toml"),
            (
                "mjcf-part-not-read",
                self._not_read,
                "not read",
                "write it out as bodies and joints, if needed",
            ),
            ("mjcf-loop-open", self._loose, "not kept: the joints move freely", "lock or couple them in a URDF copy"),
        ]
        for code, things, what, remedy in told:
            if things:
                more = f" and {len(things) - SHOWN} more" if len(things) > SHOWN else ""
                reading.note(code, None, f"{', '.join([*things][:SHOWN])}{more}: {what}", remedy)

    @contextmanager
    def _told(self, element: ET.Element) -> Iterator[None]:
        """Put the place of an element before the message about a malformed number in it."""
        try:
            yield
        except ValueError as error:
            raise self.mjcf.error(element, str(error)) from error
