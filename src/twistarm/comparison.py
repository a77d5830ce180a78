"""The cross-check at length: product of exponentials, Pinocchio, yourdfpy and finite differences against each other."""

from __future__ import annotations

import io
import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from . import poe
from .arm import Arm
from .checks import Array, frozen
from .errors import ComparisonError, InputError, MissingExtraError, missing_extra
from .screws import adjoint, inverse

POSE_TOL = 1e-12
"""Product of exponentials against Pinocchio: both in double precision, some ten multiplications long."""

YOURDFPY_TOL = 1e-9
"""yourdfpy reads angles through its own trigonometry and normalises axes to about nine digits."""

DIFFERENCE_TOL = 1e-8
"""What a fourth-order difference quotient with step 1e-3 leaves: h⁴ and ε/h, both below 1e-11, and room for size."""

STEP = 1e-3

YOURDFPY_SAMPLES, YOURDFPY_POSES = 200, 20_000
"""yourdfpy takes some 0.1 ms for each link's pose: at most so many postures, and so many poses in all."""

Progress = Callable[[float], object]
"""Called with the fraction done, 0 to 1."""


@dataclass(frozen=True)
class Comparison:
    """One quantity in two engines: the worst difference, where it was found, what is allowed; or why not compared."""

    quantity: str
    engines: tuple[str, str]
    samples: int = 0
    worst: float = 0.0
    tolerance: float = 0.0
    theta: Array | None = None
    not_compared: str = ""

    @property
    def ok(self) -> bool:
        """Within the tolerance, or not compared."""
        return bool(self.not_compared) or self.worst <= self.tolerance


@dataclass(frozen=True)
class CrossCheck:
    """Every comparison made of one arm."""

    arm: str
    comparisons: tuple[Comparison, ...]

    @property
    def ok(self) -> bool:
        """Everything that was compared agrees."""
        return all(row.ok for row in self.comparisons)

    @property
    def left_out(self) -> dict[str, str]:
        """Engines that compared nothing, each with the reason."""
        heard = {engine for row in self.comparisons if not row.not_compared for engine in row.engines}
        return {row.engines[1]: row.not_compared for row in self.comparisons if row.engines[1] not in heard}

    def worst(self, engine: str) -> float:
        """The worst difference of the comparisons with that engine; 0 if there was none."""
        rows = [row.worst for row in self.comparisons if engine in row.engines and not row.not_compared]
        return max(rows, default=0.0)

    def require(self) -> CrossCheck:
        """Itself, or ComparisonError naming every quantity that disagrees and where."""
        if self.ok:
            return self
        lines = [
            f"{row.quantity}: {row.engines[0]} and {row.engines[1]} differ by {row.worst:.2g} "
            f"(allowed {row.tolerance:g}) at theta = {np.array2string(np.asarray(row.theta), precision=6)}"
            for row in self.comparisons
            if not row.ok
        ]
        raise ComparisonError(f"{self.arm}: " + "; ".join(lines))


def crosscheck(
    arm: Arm, samples: int = 1000, rng: int | np.random.Generator = 0, progress: Progress | None = None
) -> CrossCheck:
    """Compare the engines at `samples` random configurations; `progress(fraction)` is called after each part.

    Pose, J^s and J^b of the product of exponentials against Pinocchio; every link's pose by our walk of the
    description against Pinocchio; J^s = Ad(g) J^b; J^b against fourth-order central differences of Pinocchio's pose;
    pose of every link against yourdfpy, which reads the expanded but unrepaired text. What an engine cannot do is
    "not compared", with the reason. Absolute errors, in metres and radians (entries of R); allowed are `POSE_TOL`
    times the arm's size where that exceeds 1 m.
    """
    if isinstance(samples, bool) or not isinstance(samples, (int, np.integer)) or samples < 1:
        raise InputError(f"samples must be a whole number, at least 1; got {samples!r}")
    if not isinstance(rng, np.random.Generator) and not (isinstance(rng, (int, np.integer)) and rng >= 0):
        raise InputError(f"rng must be a seed ≥ 0 or a NumPy Generator; got {rng!r}")
    theta = arm.random_theta(np.random.default_rng(rng), int(samples))
    parts: list[Callable[[], Iterable[Comparison]]] = [
        lambda: _pinocchio(arm, theta),
        lambda: _differences(arm, theta),
        lambda: _links(arm, theta),
        lambda: _yourdfpy(arm, theta),
    ]
    rows: list[Comparison] = []
    for done, part in enumerate(parts, start=1):
        rows += part()
        if progress is not None:
            progress(done / len(parts))
    return CrossCheck(arm.name, tuple(rows))


def _compared(quantity: str, engines: tuple[str, str], difference: Array, theta: Array, tolerance: float) -> Comparison:
    """The worst entry of `difference` (samples, …) and the configuration it belongs to; NaN counts as infinite."""
    errors = np.abs(np.nan_to_num(difference, nan=np.inf)).reshape(len(theta), -1).max(axis=1)
    worst = int(errors.argmax())
    return Comparison(quantity, engines, len(theta), float(errors[worst]), tolerance, frozen(theta[worst]))


def _size(arm: Arm) -> float:
    """The arm's size [m] at least 1: its reach, where its tool stands, and the stroke of its slides."""
    slides = np.array(arm.joint_types) == "prismatic"
    stroke = float(np.abs(np.array(arm.sampling_bounds)[:, slides]).sum())
    return max(1.0, arm.reach + stroke, float(np.abs(arm.home[:3, 3]).max()))


def _pinocchio(arm: Arm, theta: Array) -> list[Comparison]:
    x, A = theta @ arm.coupling.A.T, arm.coupling.A
    g = poe.fk(arm.screws, arm.home, x)
    spatial = poe.spatial_jacobian(arm.screws, x) @ A
    body = poe.body_jacobian(arm.screws, arm.home, x) @ A
    tolerance = POSE_TOL * _size(arm)
    identity = _compared("J^s = Ad J^b", ("poe", "poe"), spatial - adjoint(g) @ body, theta, tolerance)
    if arm.description is None:
        return [_skipped("pose, J^s, J^b", "pinocchio", "an arm made from screws has no description"), identity]
    engines = ("poe", "pinocchio")
    return [
        _compared("pose", engines, g - arm.fk(theta), theta, tolerance),
        _compared("spatial Jacobian", engines, spatial - arm.spatial_jacobian(theta), theta, tolerance),
        _compared("body Jacobian", engines, body - arm.body_jacobian(theta), theta, tolerance),
        identity,
    ]


def _differences(arm: Arm, theta: Array) -> list[Comparison]:
    """(g⁻¹ ∂g/∂θ_i)^∨ by (8(g₊ − g₋) − (g₊₊ − g₋₋))/12h against the columns of J^b by product of exponentials."""
    body = poe.body_jacobian(arm.screws, arm.home, theta @ arm.coupling.A.T) @ arm.coupling.A
    back = inverse(arm.fk(theta))
    numeric = np.empty_like(body)
    for i, step in enumerate(np.eye(arm.n) * STEP):
        once, twice = (arm.fk(theta + k * step) - arm.fk(theta - k * step) for k in (1, 2))
        rate = back @ (8 * once - twice) / (12 * STEP)
        numeric[..., i] = np.stack(
            [rate[:, 0, 3], rate[:, 1, 3], rate[:, 2, 3], rate[:, 2, 1], rate[:, 0, 2], rate[:, 1, 0]], axis=-1
        )
    return [_compared("body Jacobian", ("poe", "differences"), body - numeric, theta, DIFFERENCE_TOL * _size(arm))]


def _links(arm: Arm, theta: Array) -> list[Comparison]:
    if arm.description is None:
        return []
    ours, reference = _walked_poses(arm, theta), arm.poses(theta)
    difference = np.stack([ours[link] - reference[link] for link in arm.description.links], axis=1)
    return [_compared("all links", ("walk", "pinocchio"), difference, theta, POSE_TOL * _size(arm))]


def _walked_poses(arm: Arm, theta: Array) -> dict[str, Array]:
    """Every link's pose in the base frame by our own walk of the description."""
    assert arm.description is not None
    poses = arm.description.link_poses(_joint_values(arm, theta))
    back = inverse(poses[arm.base])
    return {link: np.broadcast_to(back @ g, (len(theta), 4, 4)) for link, g in poses.items()}


def _joint_values(arm: Arm, theta: Array) -> dict[str, Array]:
    """The value (samples,) of every moving joint of the description."""
    columns = {name: theta[:, i] for i, name in enumerate(arm.joint_names)}
    zero = np.zeros(len(theta))
    return {
        name: affine.multiplier * columns.get(affine.master or "", zero) + affine.offset
        for name, affine in arm.couplings.items()
    }


def _yourdfpy(arm: Arm, theta: Array) -> list[Comparison]:
    if arm.description is None:
        return [_skipped("all links", "yourdfpy", "an arm made from screws has no description")]
    reason = _beyond_yourdfpy(arm)
    if reason:
        return [_skipped("all links", "yourdfpy", reason)]
    subset = theta[: min(YOURDFPY_SAMPLES, max(1, YOURDFPY_POSES // len(arm.description.links)))]
    try:
        theirs = _yourdfpy_poses(arm, subset)
    except MissingExtraError as error:
        return [_skipped("all links", "yourdfpy", str(error))]
    except Exception as error:  # another project's reader: whatever it raises on a file is its answer
        return [_skipped("all links", "yourdfpy", f"yourdfpy cannot read it: {type(error).__name__}: {error}")]
    difference = _our_poses(arm, subset) - theirs
    engines = ("poe", "yourdfpy")
    tip = list(arm.description.links).index(arm.tip_link)
    tolerance = YOURDFPY_TOL * _size(arm)
    return [
        _compared("pose", engines, difference[:, tip], subset, tolerance),
        _compared("all links", ("walk", "yourdfpy"), difference, subset, tolerance),
        _skipped("Jacobians", "yourdfpy", "yourdfpy computes none"),
    ]


def _our_poses(arm: Arm, theta: Array) -> Array:
    """Every link's pose (samples, links, 4, 4) by our walk, the tip's by product of exponentials."""
    assert arm.description is not None
    poses = _walked_poses(arm, theta)
    poses[arm.tip_link] = poe.fk(arm.screws, arm.home, theta @ arm.coupling.A.T) @ inverse(arm.tool)
    return np.stack([poses[link] for link in arm.description.links], axis=1)


def _yourdfpy_poses(arm: Arm, theta: Array) -> Array:
    """Every link's pose (samples, links, 4, 4) by yourdfpy."""
    assert arm.description is not None
    robot = _load_yourdfpy(arm.description.text)
    values = _joint_values(arm, theta)
    links = list(arm.description.links)
    poses = np.empty((len(theta), len(links), 4, 4))
    for k in range(len(theta)):
        robot.update_cfg({name: float(values[name][k]) for name in robot.actuated_joint_names if name in values})
        for i, link in enumerate(links):
            poses[k, i] = robot.get_transform(link, arm.base)
    return poses


def _beyond_yourdfpy(arm: Arm) -> str:
    """Why yourdfpy cannot be asked about this arm; empty if it can."""
    assert arm.description is not None
    joints = arm.description.joints
    for joint in joints.values():
        if joint.type in ("planar", "floating"):
            return f"yourdfpy takes the {joint.type} joint {joint.name!r} as fixed"
        if joint.mimic is not None and joints[joint.mimic.joint].mimic is not None:
            return f"yourdfpy drops the mimic of a mimic {joint.name!r}"
        if joint.mimic is not None and arm.couplings[joint.name].master is None:
            return f"yourdfpy cannot lock the mimic joint {joint.name!r}"
        if joint.type == "prismatic" and abs(joint.axis_length - 1.0) > POSE_TOL:
            return f"yourdfpy does not normalise the axis of the prismatic joint {joint.name!r}"
    return ""


def require_yourdfpy() -> Any:
    """The module, or the error with the command that installs it."""
    try:
        import yourdfpy
    except ImportError as error:
        raise missing_extra("the comparison with yourdfpy", "yourdfpy", "check") from error
    return yourdfpy


def _load_yourdfpy(text: str) -> Any:
    import logging

    yourdfpy = require_yourdfpy()
    # The text is UTF-8 from here on, whatever encoding the file declared.
    content = re.sub(r"^\s*<\?xml[^>]*\?>", "", text).encode("utf-8")
    logger = logging.getLogger("yourdfpy.urdf")
    level = logger.level
    logger.setLevel(logging.CRITICAL)
    try:
        return yourdfpy.URDF.load(io.BytesIO(content), load_meshes=False, build_scene_graph=True)
    finally:
        logger.setLevel(level)


def _skipped(quantity: str, engine: str, reason: str) -> Comparison:
    return Comparison(quantity, ("poe", engine), not_compared=reason)
