"""The data of an arm: numbers and names of its chain, its limits, its configurations, and its models."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields
from functools import cached_property
from types import MappingProxyType
from typing import Any, NamedTuple, TypeVar
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import ArrayLike

from ..description.chain import Affine
from ..description.findings import Finding
from ..description.tree import Description
from ..limits.actuators import Actuators
from ..limits.joint_limits import AS_GOOD_AS_UNBOUNDED, JointLimits, slides, unit_of, usual_half
from ..support.checks import (
    LARGEST_ARRAY,
    Array,
    as_floats,
    as_seed,
    as_theta,
    as_whole,
    frozen,
    require,
    require_names,
    require_one,
)
from ..support.display import in_brief, short_repr
from ..support.errors import InputError, TwistarmError, UnitsWarning, listed, unknown_name, warn
from ..support.messages import plural
from ..support.units import theta_hint
from ..theory.lower_pairs import lower_pairs
from ..theory.rotations import cross
from ..theory.screws import adjoint, inverse
from .pinocchio_model import PinocchioModel, why_no_pinocchio
from .ready_pose import Mechanism, overlapping_links, round_configuration

T = TypeVar("T")

READY, ZERO = "ready", "zero"

# Usual names of the ready configuration, the most likely first.
USUAL_NAMES = ("ready", "home", "default", "rest", "stowed")


class Configurations(Mapping[str, Array]):
    """An arm's configurations by name, theta (n,) [rad, m], in this order: ready, zero, the named states.

    A named state `ready` or `zero` replaces the computed one. `ready` is computed on first use. An unknown name
    raises UnknownNameError, a LookupError that lists the names.
    """

    def __init__(self, arm: str, n: int, named: Mapping[str, Array], ready: Callable[[], Array]) -> None:
        self._arm = arm
        self._n = n
        self._named = named
        self._ready = ready

    def __getitem__(self, name: str) -> Array:
        if name in self._named:
            return self._named[name]
        if name not in (READY, ZERO):
            known = tuple(self)
            raise unknown_name("configuration", name, known, within=self._arm, listing=f"known: {listed(known)}")
        return self._ready() if name == READY else frozen(np.zeros(self._n))

    def __contains__(self, name: object) -> bool:
        return name in (READY, ZERO) or name in self._named

    def __iter__(self) -> Iterator[str]:
        return iter(dict.fromkeys((READY, ZERO, *self._named)))

    def __len__(self) -> int:
        return len({READY, ZERO, *self._named})

    def __repr__(self) -> str:
        return f"Configurations({listed(tuple(self))})"


def theta_by_joint(arm: str, joints: tuple[str, ...], values: Any, numbers: ArrayLike | None) -> Array:
    """theta (n,) from {joint: value}, or from joint names and as many numbers. They must name every joint."""
    if isinstance(values, Mapping):
        given = dict(values)
    else:
        names, row = require_names(values, "names"), as_floats([] if numbers is None else numbers, "numbers").ravel()
        if len(names) != row.size:
            raise InputError(f"{len(names)} names but {row.size} numbers; give one number per name")
        given = dict(zip(names, row.tolist(), strict=True))
        if len(given) != len(names):
            raise InputError(f"a joint is named twice in {listed(names)}")
    for name in given:
        if name not in joints:
            raise unknown_name("joint", name, joints, within=arm, listing=f"base to tip: {listed(joints)}")
    missing = [name for name in joints if name not in given]
    if missing:
        raise InputError(
            f"no value for joint {listed(missing)} of {arm}; give every joint, the others such as in ready"
        )
    return as_theta([given[name] for name in joints], len(joints))


RANK_SAMPLES = 16  # Random configurations that show the rank of an arm. Almost every one has it.


class Coupling(NamedTuple):
    """Joint values A @ theta + b: A (m, n) and b (m,), one row per moving joint of the chain."""

    A: Array
    b: Array

    def __repr__(self) -> str:
        return short_repr("Coupling", self._asdict())


class Proof(NamedTuple):
    """The check at load: the largest differences between screws and Pinocchio over `samples` configurations."""

    pose_error: float
    jacobian_error: float
    samples: int


@dataclass(frozen=True, eq=False, repr=False)
class ArmData:
    """What an `Arm` is: its numbers, names, configurations and models. `Arm` has the meaning of each field."""

    name: str
    source: str
    base: str
    tip: str
    joint_names: tuple[str, ...]
    joint_types: tuple[str, ...]
    screws: Array
    home: Array
    coupling: Coupling
    limits: JointLimits
    reach: float
    named_states: Mapping[str, Array] = field(default_factory=dict)
    findings: tuple[Finding, ...] = ()
    proof: Proof | None = None
    description: Description | None = field(default=None, repr=False)
    couplings: Mapping[str, Affine] = field(default_factory=dict, repr=False)
    tool: Array = field(default_factory=lambda: np.eye(4), repr=False)
    tip_link: str = ""
    actuators: Actuators | None = field(default=None, repr=False)
    disabled_collisions: frozenset[tuple[str, str]] = field(default=frozenset(), repr=False)
    moving_names: tuple[str, ...] = field(default=(), repr=False)
    known_ready: Array | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        arrays = {name: frozen(getattr(self, name)) for name in ("screws", "home", "tool")}
        A, b = (frozen(part) for part in self.coupling)
        if A.shape != (len(b), len(self.joint_names)) or b.ndim != 1 or arrays["screws"].shape != (6, len(b)):
            raise InputError(f"coupling must be A (m, n) and b (m,) for screws (6, m); got {A.shape} and {b.shape}")
        tip_link, moving = self.tip_link or self.tip, self.moving_names or self.joint_names
        if self.description is not None and not self.moving_names:
            chain = self.description.chain(self.base, tip_link)
            moving = tuple(joint.name for joint in chain if joint.moving)
        states = {name: frozen(theta) for name, theta in self.named_states.items()}
        read_only = {
            **arrays,
            "coupling": Coupling(A, b),
            "tip_link": tip_link,
            "moving_names": moving,
            "known_ready": None if self.known_ready is None else frozen(self.known_ready),
            "named_states": MappingProxyType(states),
            "couplings": MappingProxyType(dict(self.couplings)),
        }
        for name, value in read_only.items():
            object.__setattr__(self, name, value)

    def __reduce__(self) -> tuple[type[ArmData], tuple[Any, ...]]:
        values = (getattr(self, field.name) for field in fields(self))
        # A mapping proxy cannot be pickled.
        return type(self), tuple(dict(value) if isinstance(value, MappingProxyType) else value for value in values)

    def __repr__(self) -> str:
        size = f"{plural(self.n, 'joint')} from {self.base} to {self.tip}, reach {self.reach:.3g} m"
        return f"Arm({self.name}: {size}; joints {in_brief(self.joint_names)})"

    @property
    def n(self) -> int:
        """Degrees of freedom: length of theta."""
        return len(self.joint_names)

    @cached_property
    def units(self) -> tuple[str, ...]:
        """`rad` or `m` for each coordinate."""
        return tuple(unit_of(kind) for kind in self.joint_types)

    @property
    def body_screws(self) -> Array:
        """ξ_i seen from the tool at theta = 0: Ad(home⁻¹) screws, (6, m). MLS §3.2.2."""
        return adjoint(inverse(self.home)) @ self.screws

    @cached_property
    def tool_axis(self) -> Array:
        """The unit vector (3,) in tool axes about which the last joint rolls the tool, outward. The default is z.

        An `Approach` points this axis by default. `roll_axis` below has the exact rule.
        """
        return roll_axis(self.body_screws, self.coupling.A, self.reach)

    @property
    def frame_names(self) -> tuple[str, ...]:
        """Every link of the description, and the tool. Without a description: base and tool."""
        links = tuple(self.description.links) if self.description else (self.base,)
        return links if self.tip in links else (*links, self.tip)

    @property
    def configurations(self) -> Configurations:
        """Configurations by name: `ready`, `zero` and `named_states`. Methods take a name as theta."""
        return Configurations(self.name, self.n, self.named_states, lambda: self.ready)

    @cached_property
    def ready_name(self) -> str | None:
        """The named state that `ready` is, None if that is computed.

        It is the first of `ready`, `home`, `default`, `rest`, `stowed`, in capitals or not, that is not singular. The
        first of them counts even if it is.
        """
        folded = {name: name.strip().casefold() for name in self.named_states}
        usual = [name for name in folded if folded[name] in USUAL_NAMES]
        for name in sorted(usual, key=lambda name: (USUAL_NAMES.index(folded[name]), name not in USUAL_NAMES)):
            samples = self.random_theta(0, RANK_SAMPLES)
            if folded[name] == "ready" or self._mechanism.regular(self.named_states[name], samples):
                return name
        return None

    @cached_property
    def ready(self) -> Array:
        """The configuration to start from, inside the limits, (n,): the one named `ready_name`, else computed."""
        if self.known_ready is not None:
            return self.known_ready
        return self.computed_ready if self.ready_name is None else self.named_states[self.ready_name]

    @cached_property
    def computed_ready(self) -> Array:
        """A well-conditioned configuration (n,) in round numbers, off the limits, the tool before and above the base.

        No two links of a description overlap in it.
        """
        overlapping = None
        if self.description is not None and not why_no_pinocchio():
            places = self.pinocchio, self.description, self.base, self.moving_names[0], self.reach
            overlapping = overlapping_links(*places, self.disabled_collisions)
        return frozen(round_configuration(self._mechanism, self.sampling_bounds, overlapping))

    @property
    def _mechanism(self) -> Mechanism:
        return Mechanism(self.screws, self.coupling.A, self.home[:3, 3], self.units, self.reach)

    @cached_property
    def middle(self) -> Array:
        """The middle of the limits, (n,). A joint without two limits is as near to 0 as its limits allow."""
        return frozen(self.limits.middle())

    @cached_property
    def pinocchio(self) -> PinocchioModel:
        """Pinocchio's model of the whole description, with data per thread. Without a description: TwistarmError."""
        if self.description is None:
            raise TwistarmError(f"{self.name} was {self._whence}: it has no Pinocchio model; load its description")
        return PinocchioModel(self.description, self.couplings, self.joint_names, self.moving_names)

    @property
    def prismatic(self) -> Array:
        """Marks (n,) the coordinates that are lengths."""
        return np.array([slides(kind) for kind in self.joint_types])

    # -- configurations ------------------------------------------------------------------------------------------

    def random_theta(self, rng: int | np.random.Generator, size: int | tuple[int, ...] | None = None) -> Array:
        """Random configurations, uniform in `sampling_bounds`.

        Args:
            rng: A seed, which gives the same configurations each time, or a NumPy Generator.
            size: How many: a number or a shape. None for a single configuration.

        Returns:
            (n,), or an array of shape `size` followed by n.

        Raises:
            InputError: The seed or the size cannot be used.
        """
        lower, upper = self.sampling_bounds
        generator = rng if isinstance(rng, np.random.Generator) else np.random.default_rng(as_seed(rng))
        lengths = () if size is None else size if isinstance(size, tuple) else (size,)
        shape = [as_whole(length, "size", 0, LARGEST_ARRAY) for length in lengths]
        return generator.uniform(lower, upper, (*shape, self.n))

    @property
    def sampling_bounds(self) -> tuple[Array, Array]:
        """The limits made finite, lower and upper (n,): a missing one is ±`usual_half`, or that far from the other."""
        return self.limits.sampling_bounds(self.usual_half)

    @cached_property
    def usual_half(self) -> Array:
        """Half the range (n,) assumed for an unbounded coordinate: π rad, 1 m.

        For a thread it is the turn that advances it 1 m, if that is more.
        """
        half = np.array([usual_half(kind) for kind in self.joint_types])
        for pair in lower_pairs(self.screws, self.coupling.A):
            if pair.kind == "helical":
                turning = self.coupling.A[pair.rows[0]] != 0.0
                half[turning] = np.clip(1.0 / abs(pair.pitch), half[turning], AS_GOOD_AS_UNBOUNDED)
        return frozen(half)

    def theta_from(
        self,
        values: ArrayLike | Mapping[str, float] | Sequence[str],
        numbers: ArrayLike | None = None,
        *,
        name: str = "theta",
    ) -> Array:
        """Check theta (..., n), or make (n,) from a name in `configurations`, {joint: value}, or joints and values.

        Values by joint must name every joint, in any order.

        Args:
            values: Numbers (..., n) [rad, m], the name of a configuration, {joint: value}, or joint names.
            numbers: The values that belong to joint names (n,). None otherwise.
            name: The argument's name in the text of an error.

        Raises:
            InputError: The shape does not fit, a number is not finite, or a joint is missing.
            UnknownNameError: No such configuration or joint.

        Warns:
            UnitsWarning: The numbers lie outside the limits and look like degrees.
        """
        theta = self._theta_of(values, numbers, require(name, str, "name", "an argument's"))
        hint = theta_hint(theta, self.units, self.limits.lower, self.limits.upper)
        if hint and numbers is None and not isinstance(values, str | Mapping):
            warn(f"{name}: {hint}; twistarm takes radians: numpy.radians converts them", UnitsWarning)
        return theta

    def _asked_at(self, theta: ArrayLike) -> Array:
        """theta (..., n) of a question. An array of many configurations was not typed: its units are not checked."""
        many = isinstance(theta, np.ndarray) and theta.ndim > 1
        return self._theta_of(theta) if many else self.theta_from(theta)

    def _theta_of(
        self, values: ArrayLike | Mapping[str, float] | Sequence[str], numbers: ArrayLike | None = None,
        name: str = "theta",
    ) -> Array:  # fmt: skip
        """theta (..., n), checked, except for its units."""
        if isinstance(values, str):
            return self.configurations[values]
        if numbers is None and not isinstance(values, Mapping):
            return as_theta(values, self.n, name, self.joint_names)
        return theta_by_joint(self.name, self.joint_names, values, numbers)

    def theta_to_dict(self, theta: ArrayLike) -> dict[str, float]:
        """{joint: value}, base to tip."""
        x = require_one(self._asked_at(theta), "theta", 1)
        return {name: float(value) for name, value in zip(self.joint_names, x, strict=True)}

    @property
    def _whence(self) -> str:
        """The origin of an arm without a description."""
        if self.source == "screws":
            return "made from screws, not from a description"
        return f"baked without its description (load {self.source!r} for that)"


# Beside the arm and not in it: an arm is plain data that is compared, copied and pickled.
_KEPT: WeakKeyDictionary[ArmData, dict[Hashable, Any]] = WeakKeyDictionary()


def kept(arm: ArmData, key: Hashable, make: Callable[[], T]) -> T:
    """The value of `make`, computed once for as long as the arm lives.

    It follows from the arm and `key` alone. The key begins with a name, so that no two modules have one key.
    """
    of_arm = _KEPT.get(arm)
    if of_arm is None:  # `setdefault` alone would make a weak reference in each step of a servo
        of_arm = _KEPT.setdefault(arm, {})
    if key not in of_arm:
        of_arm[key] = make()
    value: T = of_arm[key]
    return value


Z = frozen([0.0, 0.0, 1.0])  # The axis if no joint rolls the tool. By convention a tool points along z.
# Sine below which axes are parallel, and share of the reach below which a point lies on an axis.
ALIGNED = 1e-3
DECIMALS = 12  # Decimals of the axis. Further digits are rounding, which differs between machines.
DECISIVE = 0.5  # Some component of every unit vector is at least 1/√3.


def roll_axis(body_screws: Array, coupling: Array, reach: float) -> Array:
    """The unit vector (3,) in tool axes about which the last turning joint rolls the tool, or z.

    The columns (v, w) of `body_screws` (6, m) are the screws at rest. The row of a locked joint in `coupling` (m, n) is
    zero. Joints after the last turning joint only slide, so its axis w is fixed in the tool.

    The wrist is the point of that axis nearest to the axis of the turning joint before it. The last joint is a roll
    if the two axes are not parallel, and the tool's origin is at the wrist or within 45° of ±w. With one turning joint
    only, it is a roll if the tool's origin lies on its axis. A last joint that pitches gives z.

    The axis points outward, from the wrist to the tool's origin. If the two coincide, or only one joint turns, the
    first component of z, x, y of at least 0.5 in size is positive.
    """
    turning = np.flatnonzero((np.linalg.norm(body_screws[3:], axis=0) > 0.5) & coupling.any(axis=1))
    if not len(turning):
        return Z
    v, w = body_screws[:3].T, body_screws[3:].T
    last = w[turning[-1]]
    near = cross(last, v[turning[-1]])  # the point of the axis that is nearest to the tool's origin
    aside, out = float(np.linalg.norm(near)), 0.0
    if len(turning) > 1:
        before = turning[-2]
        across = cross(w[before], last)
        if across @ across < ALIGNED**2:
            return Z
        # Along the common perpendicular of the two lines: from the foot on the last axis to the tool's origin.
        offset = cross(w[before], v[before]) - near
        out = float(cross(offset, w[before]) @ across) / float(across @ across)
    if aside > max(abs(out), ALIGNED * reach):
        return Z
    decisive = next(value for value in last[[2, 0, 1]] if abs(value) >= DECISIVE * np.linalg.norm(last))
    sense = np.sign(out if abs(out) > ALIGNED * reach else decisive)
    return frozen(np.round(sense * last, DECIMALS) + 0.0)
