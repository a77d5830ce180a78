"""A compiled MJCF to a URDF text: bodies and sites become links, and joints keep their names."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections import defaultdict
from typing import NamedTuple

import numpy as np

from ...support.checks import Array
from ...support.messages import first_of
from ...theory.screws import exp
from ..document import Reading
from ..geometry import INERTIA
from ..planar import free_name
from ..tree import GRAVITY, GroupState, Semantics, sorted_pair
from ..writing import add_joint, add_mimic, add_origin, number_text
from .compilation import Compiled, Mjcf, compiled, pose

ROOT = "world"  # MuJoCo's name of the body that carries all others.

WORDS_OF = {
    "mjcf-scenery-left-out": ("left out", "describe obstacles in a scene.toml, and tighter limits in an arm.toml"),
    "mjcf-part-not-read": ("not read", "correct it, or write it out as bodies, joints and masses"),
    "mjcf-loop-open": ("not kept", "lock or couple the joints in a URDF copy"),
    "mjcf-gravity": ("kept for torques", "turn the arm's first body instead, if a URDF has to say it"),
}
"""The codes of findings about parts of an MJCF, what becomes of the parts, and the remedy."""

SHOWN = 8  # Most parts in one finding.
HIDDEN = 3  # The first group of geoms that MuJoCo's viewer does not show. Collision shapes usually have it.
UNPAINTED = (0.5, 0.5, 0.5, 1.0)  # The colour of a geom that gives none, or has that of its material.


class Moving(NamedTuple):
    """A joint that was written: its element, its frame (4, 4), its twist (6,), its value at rest."""

    element: ET.Element
    origin: Array
    twist: Array
    rest: float


def translated(root: ET.Element, reading: Reading) -> tuple[str, Semantics | None, tuple[float, float, float]]:
    """The URDF text of an MJCF, its poses and pairs, and the gravity (3,) [m/s²] in its root frame.

    What URDF has no word for is left out, with findings in `reading`.

    A joint that does not turn about its body's origin, or is not 0 at rest, gets a link between. A ball is fixed.
    Free bodies without joints are left out, and other free bodies are fixed. Raises DescriptionError for a file that
    MuJoCo refuses, and MissingExtraError without MuJoCo.
    """
    mjcf = Mjcf(root, [reading])
    writer = _Writer(mjcf, compiled(mjcf))
    writer.note_radians(reading)
    writer.write_bodies()
    writer.couple()
    semantics, gravity = writer.semantics(reading), writer.gravity()
    for code, parts in mjcf.notes.items():
        what, remedy = WORDS_OF[code]
        reading.note(code, None, f"{first_of([*parts], SHOWN)}: {what}", remedy)
    return ET.tostring(writer.robot, "unicode"), semantics, gravity


class _Writer:
    """The URDF as far as it is written. `bodies` and `joints` are the names of MuJoCo's, made up for those without."""

    def __init__(self, mjcf: Mjcf, found: Compiled) -> None:
        self.mjcf, self.mujoco, self.model = mjcf, found.mujoco, found.model
        self.meshes, self.unweighed = found.meshes, found.unweighed
        self.robot = ET.Element("robot", name=mjcf.root.get("model") or mjcf.readings[0].path.stem)
        ET.SubElement(self.robot, "link", name=ROOT)
        bodies, joints = self._names("BODY", self.model.nbody), self._names("JOINT", self.model.njnt)
        self.links, self.joint_names_used = {*bodies}, {*joints}
        self.bodies = [name or free_name(f"body{i}", self.links) for i, name in enumerate(bodies)]
        self.joints = [
            name or free_name(f"{self.bodies[body]}_joint", self.joint_names_used)
            for name, body in zip(joints, self.model.jnt_bodyid, strict=True)
        ]
        self.efforts = self._efforts()
        self.moving: dict[int, Moving] = {}
        self.masters: dict[int, int] = {}
        self.pairs: dict[tuple[str, str], str] = {}
        for i, name in enumerate(self._names("TENDON", self.model.ntendon)):
            mjcf.note("mjcf-scenery-left-out", f"the tendon {name or i}")

    def _names(self, kind: str, count: int) -> list[str]:
        """The names of all objects of a kind; empty for those without."""
        objects = getattr(self.mujoco.mjtObj, f"mjOBJ_{kind}")
        return [self.mujoco.mj_id2name(self.model, objects, i) or "" for i in range(count)]

    def note_radians(self, reading: Reading) -> None:
        """Note ranges in degrees that look like radians: all are within 2π."""
        if "radian" in [element.get("angle") for element in self.mjcf.root.findall("compiler")]:
            return
        # MuJoCo has compiled degrees to radians.
        hinges = (self.model.jnt_limited != 0) & (self.model.jnt_type == self.mujoco.mjtJoint.mjJNT_HINGE)
        largest = np.degrees(np.abs(self.model.jnt_range[hinges]).max(initial=0.0))
        if 0.0 < largest <= 2 * np.pi:
            what = f"joint ranges in degrees that look like radians: all are within {largest:.4g}"
            reading.note("unit-doubtful", None, what, 'if so, write <compiler angle="radian"/>')

    # -- bodies ------------------------------------------------------------------------------------------------------

    def write_bodies(self) -> None:
        """Write every body of the arm and its scene with joints, mass, sites and shapes."""
        model, contents = self.model, defaultdict[str, list[ET.Element]](list)
        loose = {i for i in range(1, model.nbody) if self._is_loose(i)}
        for i, name in enumerate(self.bodies):
            if model.body_rootid[i] in loose:
                continue
            if i > 0:
                self._body(i)
            if i in self.unweighed:
                self.mjcf.note("mjcf-part-not-read", f"the mass of {name!r}, for want of a mesh")
            elif model.body_mass[i] > 0:
                inertial = ET.Element("inertial")
                add_origin(inertial, pose(model.body_ipos[i], model.body_iquat[i]))
                ET.SubElement(inertial, "mass", value=number_text([model.body_mass[i]]))
                moments = number_text(np.diag(model.body_inertia[i])[np.triu_indices(3)]).split()
                ET.SubElement(inertial, "inertia", dict(zip(INERTIA, moments, strict=True)))
                contents[name].append(inertial)
            for k in range(model.body_geomadr[i], model.body_geomadr[i] + model.body_geomnum[i]):
                contents[name] += self._shape(k)
        for k, site in enumerate(self._names("SITE", model.nsite)):
            if site and model.body_rootid[model.site_bodyid[k]] not in loose:
                link = free_name(f"{site}_site" if site in self.links else site, self.links)
                self._fixed(link, self.bodies[model.site_bodyid[k]], pose(model.site_pos[k], model.site_quat[k]))
        for element in self.robot.findall("link"):
            element.extend(contents[element.get("name", "")])

    def _is_loose(self, i: int) -> bool:
        """Whether a body moves by itself and carries no joints, as obstacles do."""
        model, name, own = self.model, self.bodies[i], self.joints_of(i)
        free = any(model.jnt_type[j] == self.mujoco.mjtJoint.mjJNT_FREE for j in own)
        if not free and model.body_mocapid[i] < 0:
            return False
        kind = "free" if free else "mocap"
        alone = int((model.body_rootid[model.jnt_bodyid] == i).sum()) == len(own)
        part = f"the {kind} body {name!r}" if alone else f"the motion of the {kind} base {name!r}"
        self.mjcf.note("mjcf-scenery-left-out", part)
        return alone

    def joints_of(self, i: int) -> range:
        """The indices of a body's joints."""
        return range(self.model.body_jntadr[i], self.model.body_jntadr[i] + self.model.body_jntnum[i])

    def _body(self, i: int) -> None:
        """Write a body's link, on its hinges and slides."""
        model, name, kinds = self.model, self.bodies[i], self.mujoco.mjtJoint
        joints = []
        for j in self.joints_of(i):
            if model.jnt_type[j] == kinds.mjJNT_BALL:
                self.mjcf.note("mjcf-part-not-read", f"the motion of the ball {self.joints[j]!r}")
            elif model.jnt_type[j] != kinds.mjJNT_FREE:
                joints.append(j)
        parent = link = self.bodies[model.body_parentid[i]]
        g = pose(model.body_pos[i], model.body_quat[i])
        for j in joints:
            link, g = self._joint(j, link, g, name if j == joints[-1] else "")
        if link not in (parent, name):  # MuJoCo lets a body and its parent overlap
            self.pairs[sorted_pair(parent, name)] = ""
        if link != name:
            self._fixed(name, link, g)

    def _fixed(self, name: str, parent: str, g: Array) -> None:
        add_joint(self.robot, free_name(f"{name}_fixed", self.joint_names_used), "fixed", (parent, name), g)

    # -- joints ------------------------------------------------------------------------------------------------------

    def _joint(self, j: int, link: str, g: Array, body: str) -> tuple[str, Array]:
        """Write a hinge or slide on `link`, in the body's frame `g`. Return the link beyond and the body's frame in it.

        The link beyond is the `body`, if its frame fits.
        """
        model, name = self.model, self.joints[j]
        slide = bool(model.jnt_type[j] == self.mujoco.mjtJoint.mjJNT_SLIDE)
        axis, zero, rest = np.array(model.jnt_axis[j]), np.zeros(3), float(model.qpos0[model.jnt_qposadr[j]])
        twist = np.concatenate([axis, zero] if slide else [zero, axis])
        origin = pose(model.jnt_pos[j], [1.0, 0.0, 0.0, 0.0])
        back = exp(twist, -rest) @ np.linalg.inv(origin)
        beyond = body if body and np.array_equal(back, np.eye(4)) else free_name(f"{name}_link", self.links)
        limit = {"velocity": 0.0, "effort": self.efforts.get(j, 0.0)}  # 0 is read as "not given"
        if slide or model.jnt_limited[j]:
            limit["lower"], limit["upper"] = model.jnt_range[j] if model.jnt_limited[j] else (-np.inf, np.inf)
        kind = "prismatic" if slide else "revolute" if model.jnt_limited[j] else "continuous"
        element = add_joint(self.robot, name, kind, (link, beyond), g @ origin, axis, limit)
        self.moving[j] = Moving(element, g @ origin, twist, rest)
        return beyond, back

    def _efforts(self) -> dict[int, float]:
        """The largest effort of each joint, where the joint or its actuators give one."""
        model, efforts = self.model, dict[int, float]()
        fixed, none = self.mujoco.mjtGain.mjGAIN_FIXED, self.mujoco.mjtBias.mjBIAS_NONE
        on_joint = {int(self.mujoco.mjtTrn.mjTRN_JOINT), int(self.mujoco.mjtTrn.mjTRN_JOINTINPARENT)}
        for i in range(model.nu):
            if model.actuator_trntype[i] not in on_joint:
                continue
            motor = model.actuator_gaintype[i] == fixed and model.actuator_biastype[i] == none
            if model.actuator_forcelimited[i]:
                force = model.actuator_forcerange[i]
            elif model.actuator_ctrllimited[i] and motor:
                force = model.actuator_ctrlrange[i] * model.actuator_gainprm[i, 0]
            else:
                continue
            joint, effort = int(model.actuator_trnid[i, 0]), float(np.abs(force * model.actuator_gear[i, 0]).max())
            efforts[joint] = max(efforts.get(joint, 0.0), effort)
        own = {int(j): float(np.abs(model.jnt_actfrcrange[j]).max()) for j in np.flatnonzero(model.jnt_actfrclimited)}
        return efforts | own

    # -- shapes ------------------------------------------------------------------------------------------------------

    def _shape(self, k: int) -> list[ET.Element]:
        """The visual and the collision of a geom. None for a shape that URDF lacks."""
        model, kinds = self.model, self.mujoco.mjtGeom
        kind = kinds(int(model.geom_type[k])).name.removeprefix("mjGEOM_").lower()
        g, size = pose(model.geom_pos[k], model.geom_quat[k]), np.array(model.geom_size[k])
        rod = {"radius": number_text(size[:1]), "length": number_text([2 * size[1]])}
        ball, box = {"radius": rod["radius"]}, {"size": number_text(2 * size)}
        shape = {"box": box, "sphere": ball, "cylinder": rod, "capsule": rod}.get(kind)
        if kind == "mesh" and (mesh := self.meshes.get(int(model.geom_dataid[k]))):
            g, shape = g @ mesh.frame, {"filename": mesh.path, "scale": number_text(mesh.scale)}
        if shape is None:
            self.mjcf.note("mjcf-scenery-left-out", f"a shape of type {kind}")
            return []
        made = []
        if model.geom_group[k] < HIDDEN:
            name, rgba = self._colour(k)
            made.append(ET.Element("visual"))
            ET.SubElement(ET.SubElement(made[0], "material", name=name), "color", rgba=rgba)
        if model.geom_contype[k] or model.geom_conaffinity[k]:
            made.append(ET.Element("collision"))
        for element in made:
            add_origin(element, g)
            ET.SubElement(ET.SubElement(element, "geometry"), kind, shape)
        return made

    def _colour(self, k: int) -> tuple[str, str]:
        """The name and colour of a geom's material. urdfdom drops all shapes for a material without a name."""
        material, rgba = int(self.model.geom_matid[k]), self.model.geom_rgba[k]
        if material >= 0 and np.array_equal(rgba, np.array(UNPAINTED, np.float32)):
            name = self.mujoco.mj_id2name(self.model, self.mujoco.mjtObj.mjOBJ_MATERIAL, material)
            return name, _single(self.model.mat_rgba[material])
        return f"rgba {_single(rgba)}", _single(rgba)

    # -- constraints, drives, keyframes ------------------------------------------------------------------------------

    def couple(self) -> None:
        """Make followers of joints by `equality`, first those that are fixed."""
        model, names = self.model, self._names("EQUALITY", self.model.neq)
        for i in sorted(map(int, np.flatnonzero(model.eq_active0)), key=lambda i: model.eq_obj2id[i] >= 0):
            kind = self.mujoco.mjtEq(int(model.eq_type[i])).name.removeprefix("mjEQ_").lower()
            if kind != "joint" or not self._couple(i):
                self.mjcf.note("mjcf-loop-open", f"<{kind}> {names[i] or i}")

    def _couple(self, i: int) -> bool:
        """Let joint1 follow joint2, q₁ − rest₁ = a₀ + a₁ (q₂ − rest₂), or be fixed.

        False if a joint is not the arm's, the polynomial is not linear, something moves joint1 already, or joint2
        follows joint1.
        """
        first, second = int(self.model.eq_obj1id[i]), int(self.model.eq_obj2id[i])
        a0, a1, *higher = map(float, self.model.eq_data[i, :5])
        leader = second
        while leader >= 0 and leader != first:
            leader = self.masters.get(leader, -1)
        usable = {first, second} <= {*self.moving, -1} and (second < 0 or not any(higher))
        if not usable or first in self.masters or leader == first:
            return False
        self.masters[first], follower = second, self.moving[first]
        if second >= 0:
            offset = follower.rest + a0 - a1 * self.moving[second].rest
            add_mimic(follower.element, self.joints[second], a1, offset)
        else:
            follower.element.set("type", "fixed")
            follower.element[:] = [part for part in follower.element if part.tag in ("parent", "child")]
            add_origin(follower.element, follower.origin @ exp(follower.twist, follower.rest + a0))
            self.moving[first] = follower._replace(rest=-a0)  # its followers see a fixed joint, whose value is 0
        return True

    def semantics(self, reading: Reading) -> Semantics | None:
        """The keyframes as named configurations, and the pairs of `contact/exclude`; None if there are none."""
        model = self.model
        for signature in model.exclude_signature:
            self.pairs[sorted_pair(self.bodies[signature >> 16], self.bodies[signature & 0xFFFF])] = ""
        names = self._names("KEY", model.nkey)
        names_used, states = {*names}, []
        for i, (name, qpos) in enumerate(zip(names, model.key_qpos, strict=True)):
            values = {self.joints[j]: float(qpos[model.jnt_qposadr[j]]) for j in self.moving}
            if values:
                states.append(GroupState(name or free_name(f"key{i}", names_used), "", values))
        if not states and not self.pairs:
            return None
        return Semantics(reading.path, self.robot.get("name", ""), states=tuple(states), disabled=self.pairs)

    def gravity(self) -> tuple[float, float, float]:
        """The acceleration of free fall in the world's axes, with a note unless it is the usual one."""
        off = self.model.opt.disableflags & self.mujoco.mjtDisableBit.mjDSBL_GRAVITY
        x, y, z = (0.0, 0.0, 0.0) if off else map(float, self.model.opt.gravity)
        if (x, y, z) != GRAVITY:
            self.mjcf.note("mjcf-gravity", f"gravity ({x:g}, {y:g}, {z:g}) m/s²")
        return x, y, z


def _single(numbers: Array) -> str:
    """The shortest text of numbers of single precision."""
    return " ".join(str(np.float32(number)) for number in numbers)
