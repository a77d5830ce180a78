"""Loading of arms: read a file or catalogue name, choose base and tip, fit what is given beside it, compare.

Limits, named poses and actuators come from companions of the description. The comparison is with Pinocchio.
"""

from __future__ import annotations

import glob
import os
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ...description import catalog
from ...description.chain import coupling_matrix, walk_chain
from ...description.companions.arm_file import ArmSpecification, Motor, Tool, read_arm_file
from ...description.companions.data_files import unusable
from ...description.companions.joint_limits import with_file
from ...description.companions.srdf import ArmGroup, arm_groups, note_names, path_from, read_srdf, srdf_beside
from ...description.document import Reading
from ...description.findings import Finding, Place, finding, refusal
from ...description.packages import PackageIndex
from ...description.tips import choose_ends, note_choice
from ...description.tree import Description, Semantics
from ...description.urdf import ReadOptions, build_description, read_description, require_no_arguments
from ...limits.actuators import Actuators
from ...limits.joint_limits import JointLimits, by_field
from ...support.checks import Array, require_mapping
from ...support.errors import ComparisonError, InputError, UnknownNameError, closest, listed, quote
from ...support.files import FOLDER, NO_SUCH_FILE, as_path, is_file, what_is_at, why_no_file
from ...support.messages import Argument, Text, plural
from ..arm import Arm
from ..arm_data import Coupling, Proof
from ..baking import BAKED, SUFFIX, fields_of, unsealed
from ..pinocchio_model import why_no_pinocchio

DESCRIPTIONS = (".urdf", ".xacro", ".xml", "arm.toml")  # How the names of files end that a folder is given for.

PROOF_SAMPLES = 5
PROOF_TOL = 1e-9  # Largest difference of the two double precision accounts, relative to the arm's size.

# What a caller may give as limits=: all of them, some of them, or a joint_limits.yaml.
Changes = JointLimits | Mapping[str, Any] | str | os.PathLike[str]
LOCK_TOL = 1e-6  # A pose that puts a locked joint this near [rad, m] to where it is locked means the same.
# MoveIt's assistant writes four decimals: a state at a limit may read that far [rad, m] beyond it.
STATE_TOL = 1e-4


def load_arm(
    source: str | os.PathLike[str],
    *,
    base: str | None = None,
    tip: str | None = None,
    package_dirs: Iterable[str | os.PathLike[str]] = (),
    xacro_args: Mapping[str, object] | None = None,
    limits: JointLimits | Mapping[str, Any] | str | os.PathLike[str] | None = None,
    locked_joints: Mapping[str, float] | None = None,
    srdf: str | os.PathLike[str] | None = None,
    ignore_packages: Iterable[str] = (),
    env_vars: Iterable[str] = (),
) -> Arm:
    """Load an arm from a URDF, xacro or MJCF file, an arm.toml, or by its name in the catalogue (`available_arms()`).

    A Denavit–Hartenberg table in a CSV file loads too if a column gives its convention. An arm.json of `bake` is
    read without Pinocchio. Of the options it takes only `limits`. Arguments win over the arm.toml, and the arm.toml
    wins over the SRDF.

    The screws and the home pose come from twistarm's own reading of the description. Pinocchio's model is built
    independently, and the two are compared at five random configurations (`arm.proof`).

    Args:
        source: A URDF, xacro or MJCF file, an arm.toml, a DH table (.csv), a baked arm.json, or a name of
            `available_arms()`.
        base: The base link. By default the root link, or, on a vehicle, the first link of the arm itself.
        tip: The tip link. By default the tip of the SRDF's only arm group, or the link that is most likely the tool. A
            finding names it and the other candidates.
        package_dirs: Folders with packages, in addition to those found around the file.
        xacro_args: Values of xacro arguments, {name: value}.
        limits: Limits that replace those of the description, in SI units: {"velocity": 1.0} for every joint,
            {"velocity": {"elbow": 1.0}} for one, a `JointLimits`, or the path of a joint_limits.yaml.
        locked_joints: Joints held at a fixed value, {joint: value} [rad, m]; they have no coordinate in theta.
        srdf: An SRDF file. By default the one of this robot that is found near the description.
        ignore_packages: Packages that a xacro file includes and that the arm does not need (a sensor, a simulator).
            Their includes, and the macros that these define, are left out, and a finding lists each of them.
        env_vars: Names of the environment variables that a xacro file may read. Any other counts as unset, and a
            finding says so.

    Returns:
        The `Arm`, with findings about the description in `arm.findings`.

    Raises:
        DescriptionError: The description cannot be used. The message gives file, element and remedy.
        UnknownNameError: No such arm, link or joint. The message gives the closest names.
        InputError: An argument cannot be used.
        ComparisonError: The screws and Pinocchio's model disagree.
    """
    wishes: dict[str, Any] = {"base": base, "tip": tip, "srdf": srdf, "locked_joints": locked_joints}
    wishes |= {"package_dirs": package_dirs, "xacro_args": xacro_args}
    wishes |= {"ignore_packages": ignore_packages, "env_vars": env_vars}
    if is_baked(source):
        return _baked_arm(as_path(source), wishes, limits)
    specification = specify(source, **wishes)
    description = read(specification)
    return proven(assemble(description, specification, {} if limits is None else limits))


def proven(arm: Arm) -> Arm:
    """The arm with its proof, or without Pinocchio with a finding."""
    missing = why_no_pinocchio()
    if missing:
        place = Place(Path(arm.source).name)
        what = "without Pinocchio its kinematics are not compared and its collisions not known"
        unproven = finding("not-compared", place, what, missing)
        return replace(arm, findings=(*arm.findings, unproven))
    return replace(arm, proof=prove(arm))


def is_baked(source: str | os.PathLike[str]) -> bool:
    """Whether `source` is an existing file named like a baked arm."""
    if not isinstance(source, (str, os.PathLike)):
        return False
    path = as_path(str(os.fspath(source)))
    return path.suffix == SUFFIX and is_file(path)


def arm_of(content: Mapping[str, Any]) -> Arm:
    """The arm of a sealed file's content."""
    fields = fields_of(content)
    proof = fields.pop("proof")
    return Arm(**fields, proof=None if proof is None else Proof(*proof))


def _baked_arm(path: Path, wishes: Mapping[str, Any], changes: Changes | None) -> Arm:
    """The arm of an arm.json with the caller's limits. InputError for any other wish."""
    content = unsealed(path, BAKED)
    arm = arm_of(content)
    for name, wish in wishes.items():
        if wish and wish != getattr(arm, name, None):
            raise InputError(
                f"{path}: {name} cannot be given for a baked arm, only for its description, {arm.source!r}"
            )
    if changes is None:
        return arm
    specification = ArmSpecification(path, str(path))
    limits, noted = fitted_limits(arm.limits, arm.joint_names, specification, changes, arm.moving_names)
    states = {name: theta for name, theta in arm.named_states.items() if limits.contains(theta)}
    what, remedy = "it lies outside the limits that were given; it is left out", "correct them, where the arm needs it"
    places = [Place(path.name, None, "named_states", name) for name in arm.named_states if name not in states]
    noted = (*noted, *(finding("outside-limits", place, what, remedy) for place in places))
    return replace(arm, limits=limits, named_states=states, findings=noted, known_ready=None)


def specify(
    source: str | os.PathLike[str],
    base: str | None = None,
    tip: str | None = None,
    srdf: str | os.PathLike[str] | None = None,
    locked_joints: Mapping[str, float] | None = None,
    **options: Any,
) -> ArmSpecification:
    """The specification of `load_arm`'s arguments but `limits`, which need no file; they win over an arm.toml's."""
    for name, value in {"base": base, "tip": tip}.items():
        if value is not None and not (isinstance(value, str) and value.strip()):
            raise InputError(f"{name} must be the name of a link; got {quote(value)}")
    if srdf is not None and not isinstance(srdf, (str, os.PathLike)):
        raise InputError(f"srdf must be the path of an SRDF file; got {quote(srdf)}")
    locked = {} if locked_joints is None else require_mapping(locked_joints, "locked_joints", "{'slide': 0.1}")
    wishes = ReadOptions(**options)
    specification = _specification(source)
    return replace(
        specification,
        other_chain=base not in (None, specification.base) or tip not in (None, specification.tip),
        base=base or specification.base,
        tip=tip or specification.tip,
        tool=None if tip else specification.tool,
        options=wishes.over(specification.options),
        locked_joints={**specification.locked_joints, **locked},
        srdf=srdf or specification.srdf,
    )


def read(specification: ArmSpecification) -> Description:
    """The description that a specification names, or that of a DH table in a CSV file."""
    if specification.description.suffix.lower() == ".csv":
        from ...description.dh import dh_urdf, rows_of_csv, table_of_rows  # few arms have a table

        file = specification.description.resolve()
        require_no_arguments(file, specification.options, "a DH table")
        try:
            text = dh_urdf(table_of_rows(rows_of_csv(file)), specification.name or file.stem)
        except InputError as error:
            raise unusable(file, f"as a DH table: {error}") from error
        return build_description(text, Reading(file, PackageIndex(file), show_lines=False))
    return read_description(specification.description, specification.options)


def available_arms() -> tuple[str, ...]:
    """Names that `load_arm` knows: our arms, and those of the example-robot-data wheel (`models` extra)."""
    return (*catalog.own_arms(), *catalog.model_arms())


def prove(arm: Arm) -> Proof:
    """Compare the screws with Pinocchio at five seeded configurations. ComparisonError if they differ."""
    theta = arm.random_theta(0, PROOF_SAMPLES)
    g, J, _ = arm.by_exponentials(theta)
    reference, spatial, _ = arm.by_pinocchio(theta)
    proof = Proof(
        pose_error=float(np.abs(g - reference).max()),
        jacobian_error=float(np.abs(J - spatial).max()),
        samples=PROOF_SAMPLES,
    )
    far = arm.description.extent if arm.description else 0.0
    size = 1.0 + max(far, float(np.abs(reference[..., :3, 3]).max()))
    wide = float(np.abs(np.column_stack(arm.coupling)).max(initial=1.0))
    if not max(proof.pose_error, proof.jacobian_error) <= PROOF_TOL * size**2 * wide:
        raise ComparisonError(
            f"{arm.name}: product of exponentials and Pinocchio disagree by {proof.pose_error:.2g} (pose) and "
            f"{proof.jacobian_error:.2g} (Jacobian); please report it with the description"
        )
    return proof


def _specification(source: str | os.PathLike[str]) -> ArmSpecification:
    """The specification of a path or a catalogue name. An existing file wins over a name."""
    if not isinstance(source, (str, os.PathLike)):
        raise InputError(f"source must be a path or a name; got {quote(source)}")
    text = str(os.fspath(source))
    path = as_path(text)
    if is_baked(path):
        raise InputError(f"{path} is a baked arm, which has no description; give the file that it was baked from")
    if is_file(path):
        return read_arm_file(path) if path.suffix.lower() == ".toml" else ArmSpecification(path, text)
    own = catalog.own_arm_file(text)
    if own is not None:
        return replace(read_arm_file(own), source=text)
    entry = catalog.model_entry(text)
    if entry is not None:
        options = ReadOptions(package_dirs=(entry.share,))
        return ArmSpecification(entry.file, text, name=text, base=entry.base, tip=entry.tip, options=options)
    what = what_is_at(path)
    if what != NO_SUCH_FILE or path.suffix or len(path.parts) > 1:
        remedy = "give a URDF, xacro or MJCF file, a DH table, an arm.toml or an arm of the catalogue"
        if what == FOLDER:
            # Path.glob would raise for a folder that goes meanwhile.
            inside = (name for levels in ("*", "*/*", "*/*/*") for name in sorted(glob.glob(levels, root_dir=path)))
            files = listed(one for one in inside if one.endswith(DESCRIPTIONS) and not one.endswith("package.xml"))
            remedy = f"give a file in it: {files}" if files else "no description is in it: give another folder's file"
        raise refusal("file-unreadable", Place(text[:200]), why_no_file(path), remedy)
    names = available_arms()
    raise UnknownNameError(
        f"no arm {text!r} in the catalogue, nor a file of that name{closest(text, names)} (arms: {', '.join(names)})"
    )


def assemble(description: Description, specification: ArmSpecification, changes: Changes) -> Arm:
    """The arm of a description and its specification, before the proof. `changes` are the caller's limits."""
    semantics, noted = _semantics(description, specification)
    description = replace(description, semantics=semantics)
    base, tip, group, chosen = _ends(description, specification, semantics)
    tool = specification.tool or Tool(tip, np.eye(4))
    if specification.tool and tool.name in description.links:
        what = f"tool.name {tool.name!r} is a link already"
        raise refusal("companion-unusable", Place(specification.source), what, "name it otherwise")
    chain = walk_chain(description, base, tip, tool.g_tip_tool, specification.locked_joints)
    limits, limiting = fitted_limits(chain.limits, chain.coordinates, specification, changes, description.joints)
    arm = Arm(
        name=specification.name or description.name,
        source=specification.source,
        base=base,
        tip=tool.name,
        joint_names=chain.coordinates,
        joint_types=chain.types,
        screws=chain.screws,
        home=chain.home,
        coupling=Coupling(*chain.coupling),
        limits=limits,
        reach=chain.reach or 1.0,
        findings=(*description.findings, *specification.findings, *noted, *chosen, *chain.findings, *limiting),
        description=description,
        couplings=chain.couplings,
        tool=tool.g_tip_tool,
        tip_link=tip,
    )
    return _with_srdf(arm, specification, semantics, group)


def _semantics(
    description: Description, specification: ArmSpecification
) -> tuple[Semantics | None, tuple[Finding, ...]]:
    """The named SRDF or the one beside the description, and the findings about it."""
    if specification.srdf is None and description.gravity is not None:  # an MJCF
        return description.semantics, ()
    if specification.srdf is None:
        semantics, noted = srdf_beside(description)
    else:
        semantics, noted = read_srdf(specification.srdf, specification.options), ()
    return semantics, noted if semantics is None else (*noted, *note_names(semantics, description))


def _ends(
    description: Description, specification: ArmSpecification, semantics: Semantics | None
) -> tuple[str, str, ArmGroup | None, Sequence[Finding]]:
    """Base, tip, the group of the tip, and findings. They are named, from the only arm group, or chosen."""
    groups = arm_groups(semantics, description) if semantics else ()
    base = description.require_link(specification.base, "base") if specification.base else None
    if specification.tip:
        tip = description.require_link(specification.tip, "tip")
        return base or description.root, tip, next((group for group in groups if group.tip == tip), None), ()
    if len(groups) == 1:
        return base or groups[0].base or description.root, groups[0].tip, groups[0], ()
    choice = choose_ends(description, base, map(str, groups))
    return choice.base, choice.tip, None, note_choice(description, choice)


def _with_srdf(arm: Arm, specification: ArmSpecification, semantics: Semantics | None, group: ArmGroup | None) -> Arm:
    """The arm with its actuators and the arm.toml's configurations, and the states and disabled pairs of the SRDF.

    A finding names the `ready` pose, unless the arm.toml has a pose `ready`.
    """
    poses, noted = fitted_poses(arm, specification, semantics, group.name if group else "")
    actuators, driving = fitted_actuators(arm, specification)
    arm = replace(arm, named_states=poses, actuators=actuators, findings=(*arm.findings, *driving))
    if semantics is not None and arm.description is not None:
        pairs, states = semantics.disabled_collisions(arm.description.links), len(set(poses) - set(specification.poses))
        used = [f"the tip {group.tip!r} (group {group.name!r})"] if group and not specification.tip else []
        used += [plural(states, "named configuration")] if states else []
        used += [f"{plural(len(pairs), 'pair')} of links that need no collision check"] if pairs else []
        what = f"{path_from(arm.description, semantics.path)} gives {', '.join(used) or 'nothing that the arm uses'}"
        given = {name: Argument(name, None) for name in ("tip", "srdf")}
        remedy = Text("{tip}, an arm.toml or another {srdf} overrides it", **given)
        noted.insert(0, finding("srdf-found", Place(semantics.path.name), what, remedy))
        if passive := [name for name in arm.joint_names if name in semantics.passive_joints]:
            what = f"passive joints, which no motor drives, count as driven: {listed(passive)}"
            remedy = Text("pass {locked}, or couple them by <mimic>", locked=Argument("locked_joints", None))
            noted.append(finding("companion-doubtful", Place(semantics.path.name), what, remedy))
        arm = replace(arm, disabled_collisions=pairs)
    arm = replace(arm, findings=(*arm.findings, *noted))
    name = arm.ready_name
    own = name in specification.poses
    if name is None or (own and name == "ready"):
        return arm
    place = Place(specification.source, None, "pose", name)
    if not own and semantics is not None:
        place = Place(semantics.path.name, None, "group_state", name)
    what = f"the ready configuration, where programs start, is the one named {name!r}"
    named = finding("ready-named", place, what, "[poses.ready] in an arm.toml overrides it")
    return replace(arm, findings=(*arm.findings, named))


def fitted_limits(
    limits: JointLimits,
    names: tuple[str, ...],
    specification: ArmSpecification,
    changes: Changes,
    joints: Collection[str],
) -> tuple[JointLimits, tuple[Finding, ...]]:
    """The description's limits, then the arm.toml's file and entries by joint, then the caller's.

    `names` are the chain's coordinates, `joints` all joints of the description. The arm.toml's limits of locked joints
    and of those off a requested chain are left out.
    """
    noted: tuple[Finding, ...] = ()
    left_out = {*specification.locked_joints, *(set(joints).difference(names) if specification.other_chain else ())}
    own = {joint: its for joint, its in specification.limits.items() if joint not in left_out}
    if specification.joint_limits is not None:
        limits, noted = with_file(limits, names, joints, specification.joint_limits)
    with _in_the_arm_file(specification):
        limits = limits.with_(by_field(own), names)
    if isinstance(changes, (str, os.PathLike)):
        limits, more = with_file(limits, names, joints, changes)
        return limits, (*noted, *more)
    if not isinstance(changes, JointLimits):
        return limits.with_(changes, names), noted
    if changes.lower.size != len(names):
        raise InputError(f"limits must be those of {len(names)} joints ({', '.join(names)}); got {changes.lower.size}")
    return changes, noted


@contextmanager
def _in_the_arm_file(specification: ArmSpecification) -> Iterator[None]:
    """Errors about names and values as those of the arm.toml."""
    try:
        yield
    except (ValueError, LookupError) as error:
        raise refusal("companion-unusable", Place(specification.source), str(error)) from error


def fitted_poses(
    arm: Arm, specification: ArmSpecification, semantics: Semantics | None, group: str
) -> tuple[dict[str, Array], list[Finding]]:
    """The configurations of the arm.toml, then those of the SRDF, with findings; of one name the first, or `group`'s.

    One that is incomplete, outside the limits or against a locked joint is left out. In an arm.toml it is a
    DescriptionError, unless it moves a locked joint or lacks one of another chain. Values of the SRDF that are rounded
    beyond a limit are moved onto it.
    """
    poses, noted, file = dict[str, Array](), list[Finding](), semantics.path.name if semantics else ""
    given = [(Place(specification.source, None, "pose", name), its) for name, its in specification.poses.items()]
    every = sorted(semantics.states if semantics else (), key=lambda state: state.group != group)
    states = [state for state in every if any(name in state.values for name in arm.joint_names)]
    if beside := {state.name for state in every} - {state.name for state in states}:
        what = f"states of joints outside the arm are left out: {listed(sorted(beside))}"
        remedy = Text("hold such a joint by {locked}", locked=Argument("locked_joints", None))
        noted.append(finding("companion-not-used", Place(file), what, remedy))
    given += [(Place(file, None, "group_state", state.name), state.values) for state in states]
    elsewhere = arm.description.joints if specification.other_chain and arm.description else ()
    known = {*arm.joint_names, *specification.locked_joints, *elsewhere}
    for place, values in given:
        own, name = place.element == "pose", place.name
        if name in poses:
            continue
        code, reason = _unfit(arm, values, specification.locked_joints, 0.0 if own else STATE_TOL)
        unknown = [joint for joint in values if own and joint not in known]
        if unknown or (own and (code == "outside-limits" or (code == "companion-not-used" and not elsewhere))):
            why = f"no joint {unknown[0]!r} in {arm.name}{closest(unknown[0], known)}" if unknown else reason
            what = f"poses.{name}: {why}"
            raise refusal("companion-unusable", Place(specification.source), what, "correct it or the limits")
        if reason:
            noted.append(finding(code, place, f"{reason}; it is left out", "correct it, where the arm needs it"))
        else:
            theta = arm.theta_from({joint: values[joint] for joint in arm.joint_names}, name=name)
            poses[name] = np.clip(theta, arm.limits.lower, arm.limits.upper)
    return poses, noted


def _unfit(arm: Arm, values: Mapping[str, float], locked_joints: Mapping[str, float], tol: float) -> tuple[str, str]:
    """Code and reason why a pose or state does not fit this arm; empty if it does."""
    for joint, value in locked_joints.items():
        if abs(values.get(joint, value) - value) > LOCK_TOL:
            return "companion-doubtful", f"it moves the locked joint {joint}"
    if missing := [name for name in arm.joint_names if name not in values]:
        return "companion-not-used", f"no value for joint {listed(missing)}"
    theta, lower, upper = np.array([values[name] for name in arm.joint_names]), arm.limits.lower, arm.limits.upper
    beyond = np.maximum(lower - theta, theta - upper)
    worst = int(beyond.argmax())
    if beyond[worst] > tol:
        what = f"{arm.joint_names[worst]} = {theta[worst]:g} lies outside its limits"
        return "outside-limits", f"{what} [{lower[worst]:g}, {upper[worst]:g}]"
    return "", ""


def fitted_actuators(arm: Arm, specification: ArmSpecification) -> tuple[Actuators | None, list[Finding]]:
    """The motors of an arm.toml on theta. G and o include locked joints and mimic followers.

    Raises DescriptionError for a joint outside the chain. If the caller asks for another chain, motors beyond it are
    left out.
    """
    noted: list[Finding] = []
    motors: list[Motor] = []
    here = {joint for joint, affine in arm.couplings.items() if affine.master in (None, *arm.joint_names)}
    for motor in specification.motors:
        beyond = [joint for joint in motor.ratio if joint not in here]
        if not beyond:
            motors.append(motor)
        elif specification.other_chain and set(beyond) <= set(arm.couplings):
            place = Place(specification.source, None, "actuator", motor.name)
            what = f"it drives {listed(beyond)}, outside this chain; it is left out"
            noted.append(finding("off-the-chain", place, what, "nothing, where that is meant"))
        else:
            joint, names = beyond[0], arm.joint_names
            what = f"actuators.{motor.name}.ratio: no joint {joint!r} in {arm.name}{closest(joint, names)}"
            remedy = f"its joints, base to tip: {listed(names)}"
            raise refusal("companion-unusable", Place(specification.source), what, remedy)
    if not motors:
        return None, noted
    names, driven = tuple(motor.name for motor in motors), sorted({joint for motor in motors for joint in motor.ratio})
    ratios = np.array([[motor.ratio.get(joint, 0.0) for joint in driven] for motor in motors])
    A, b = coupling_matrix(arm.couplings, driven, arm.joint_names)
    with _in_the_arm_file(specification):
        actuators = Actuators(
            names=names,
            joint_names=arm.joint_names,
            G=ratios @ A,
            offset=np.array([motor.offset for motor in motors]) + ratios @ b,
            units=tuple(motor.unit for motor in motors),
            ticks_per_turn=np.array([np.nan if m.ticks_per_turn is None else m.ticks_per_turn for m in motors]),
            limits=JointLimits.unbounded(len(motors)).with_(by_field({m.name: m.limits for m in motors}), names),
        )
    return actuators, noted
