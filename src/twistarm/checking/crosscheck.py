"""The cross-check: product of exponentials, compiled core, Pinocchio, yourdfpy and finite differences."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ..arm.arm import Arm, require_arm
from ..arm.pinocchio_model import why_no_pinocchio
from ..description.bounds import NO_LIMIT
from ..support.checks import Array, Progress, as_whole, frozen, reporting
from ..support.display import Brief
from ..support.errors import ComparisonError, InputError, MissingExtraError
from ..theory.screws import adjoint, inverse
from .other_readers import as_written, beyond_yourdfpy, yourdfpy_poses

# Product of exponentials against Pinocchio: both in double precision, some ten multiplications long.
POSE_TOL = 1e-12
AS_WRITTEN = "pinocchio as written"  # The engine that reads the unchanged text.
WRITTEN_TOL = 1e-10  # Its parser rounds an axis near x, y or z.
# yourdfpy's scene graph takes a joint's pose within 1e-8 of the identity, or of the one before, for the same.
YOURDFPY_TOL = 1e-7
# What a fourth-order difference quotient with step 1e-3 leaves: h⁴ and ε/h, both below 1e-11, and room for size.
DIFFERENCE_TOL = 1e-8
WIDE_ANGLE = 1e3  # rad; up to here an angle's own rounding stays below `POSE_TOL`.
STEP, SMALLEST_STEP = 1e-3, 1e-7  # Of the joint that moves most, in rad or m.
SLOW_SAMPLES = 100  # Configurations for the readers that walk all links in Python.
# Links of a description for all readers and for yourdfpy, and joints of a chain times coordinates. Of larger ones
# fewer configurations are compared, so that it takes as long and as much memory.
USUAL_LINKS, YOURDFPY_LINKS, USUAL_PRODUCT = 150, 20, 1024
MOST_SAMPLES = 10_000_000  # Of an hour or so; more are a mistake.


@dataclass(frozen=True, repr=False)
class EngineComparison(Brief):
    """One quantity in two engines: the worst difference, its place, the allowed one; or why it was not compared."""

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


@dataclass(frozen=True, repr=False)
class CrossCheck:
    """Every comparison made of one arm."""

    arm: str
    comparisons: tuple[EngineComparison, ...]

    def __repr__(self) -> str:
        compared = [row for row in self.comparisons if not row.not_compared]
        worst = max((row.worst for row in compared), default=0.0)
        verdict = "all agree" if self.ok else f"{sum(not row.ok for row in self.comparisons)} disagree"
        return f"CrossCheck({self.arm}: {len(compared)} comparisons, {verdict}, worst {worst:.2g})"

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
    """Compare the kinematics of independent engines at random configurations inside the limits.

    Pose, J^s and J^b are those of the product of exponentials, of Pinocchio's model and of the compiled core. An
    arm made from screws has no model of Pinocchio.

    Further comparisons are J^s = Ad(g) J^b, and J^b against fourth-order central differences of Pinocchio's pose. Every
    link's pose by our walk is compared with Pinocchio. Pinocchio and yourdfpy also read the unrepaired text of the
    file, or xacro's output without our changes. Both give every link's pose. Pinocchio gives the position limits too.
    Of an MJCF they read the URDF that MuJoCo's compilation gave. Masses are not compared. A quantity that an engine
    lacks is "not compared", with the reason.

    Errors are absolute, in metres and radians (entries of R). The tolerance is `POSE_TOL`, times the arm's size beyond
    1 m, and larger for the unrepaired text.

    Args:
        arm: The arm.
        samples: Number of configurations.
        rng: Seed, or a NumPy Generator.
        progress: Called with the fraction done, in (0, 1], after each comparison; or None.

    Returns:
        The `CrossCheck`: an `EngineComparison` for each quantity and pair of engines, with the worst difference.

    Raises:
        InputError: An argument cannot be used. A difference raises nothing here: see `CrossCheck.require`.
    """
    theta = require_arm(arm).random_theta(rng, as_whole(samples, "samples", 1, MOST_SAMPLES))
    report_progress, parts = reporting(progress), (_kinematics, _differences, _links, _as_written, _yourdfpy)
    rows: list[EngineComparison] = []
    for done, part in enumerate(parts, start=1):
        rows += part(arm, theta)
        report_progress(done / len(parts))
    if arm.description is not None and arm.description.gravity is not None:  # an MJCF
        rows.append(_skipped("all links", "mujoco", "MuJoCo compiled this file, so it is not independent"))
    return CrossCheck(arm.name, tuple(rows))


def _compared(
    quantity: str, engines: tuple[str, str], difference: Array, theta: Array, tolerance: float
) -> EngineComparison:
    """The worst entry of `difference` (samples, …) and its configuration. NaN counts as infinite."""
    errors = np.abs(np.nan_to_num(difference, nan=np.inf)).reshape(len(theta), -1).max(axis=1)
    worst = int(errors.argmax())
    return EngineComparison(quantity, engines, len(theta), float(errors[worst]), tolerance, frozen(theta[worst]))


def _size(arm: Arm) -> float:
    """The arm's size [m], at least 1: its reach, its furthest link, and the stroke of its slides.

    The size grows for joints that turn so far, or so much faster than their masters, that rounding matters.
    """
    furthest = np.abs(np.array(arm.sampling_bounds)).max(axis=0)
    values = np.abs(arm.coupling.A) @ furthest + np.abs(arm.coupling.b)
    turning = (arm.screws[3:] != 0.0).any(axis=0)
    far = max(float(np.abs(arm.home[:3, 3]).max()), arm.description.extent if arm.description else 0.0)
    size = max(1.0, arm.reach + float(values[~turning].sum()), far)
    faster = float(np.abs(arm.coupling.A).max(initial=1.0))
    return size * max(faster, float(values[turning].max(initial=0.0)) / WIDE_ANGLE)


def _fewer(theta: Array, size: int, usual: int) -> Array:
    """The first of the configurations, as many fewer as `size` exceeds what is usual."""
    return theta[: max(1, len(theta) * usual // max(size, usual))]


def _kinematics(arm: Arm, theta: Array) -> Iterator[EngineComparison]:
    """Pose and Jacobians against Pinocchio and the compiled core, which answers for the arm if it was built."""
    ours, tolerance = arm.by_exponentials(theta), POSE_TOL * _size(arm)
    without = "the arm has no description" if arm.description is None else why_no_pinocchio()
    for engine, reason in (("pinocchio", without), ("core", "" if arm.compiled else arm.why_not_compiled)):
        if reason:
            yield _skipped("pose, J^s, J^b", engine, reason)
            continue
        if engine == "pinocchio":
            theirs = arm.by_pinocchio(theta)
        else:
            theirs = arm.fk(theta), arm.spatial_jacobian(theta), arm.body_jacobian(theta)
        for quantity, one, other in zip(("pose", "spatial Jacobian", "body Jacobian"), ours, theirs, strict=True):
            yield _compared(quantity, ("poe", engine), one - other, theta, tolerance)
    g, spatial, body = ours
    yield _compared("J^s = Ad J^b", ("poe", "poe"), spatial - adjoint(g) @ body, theta, tolerance)


def _differences(arm: Arm, theta: Array) -> Iterator[EngineComparison]:
    """(g⁻¹ ∂g/∂θ_i)^∨ by (8(g₊ − g₋) − (g₊₊ − g₋₋))/12h against the columns of J^b by product of exponentials."""
    theta = _fewer(theta, arm.coupling.A.size, USUAL_PRODUCT)
    _, _, body = arm.by_exponentials(theta)
    back = inverse(arm.fk(theta))
    numeric = np.empty_like(body)
    turns = np.abs(arm.coupling.A) * np.linalg.norm(arm.screws[3:], axis=0)[:, None]
    # A coordinate that turns its joints many times as far, all together, gets a step as many times smaller.
    steps = STEP / np.maximum(1.0, turns.sum(axis=0))
    if steps.min() < SMALLEST_STEP:
        reason = f"a follower turns {turns.max():g} times as far as its master: rounding hides a difference"
        yield _skipped("body Jacobian", "differences", reason)
        return
    for i, step in enumerate(np.diag(steps)):
        once, twice = (arm.fk(theta + k * step) - arm.fk(theta - k * step) for k in (1, 2))
        rate = back @ (8 * once - twice) / (12 * steps[i])
        numeric[..., i] = np.stack(
            [rate[:, 0, 3], rate[:, 1, 3], rate[:, 2, 3], rate[:, 2, 1], rate[:, 0, 2], rate[:, 1, 0]], axis=-1
        )
    yield _compared("body Jacobian", ("poe", "differences"), body - numeric, theta, DIFFERENCE_TOL * _size(arm))


def _walked(arm: Arm, theta: Array) -> Array:
    """The pose of every link (samples, links, 4, 4) by our own walk."""
    poses = arm.walked_poses(theta)
    return np.stack([poses[link] for link in (arm.description.links if arm.description else ())], axis=1)


def _links(arm: Arm, theta: Array) -> Iterator[EngineComparison]:
    if arm.description is not None and not why_no_pinocchio():
        theta, tolerance = _fewer(theta, len(arm.description.links), USUAL_LINKS), POSE_TOL * _size(arm)
        reference = arm.poses(theta)
        theirs = np.stack([reference[link] for link in arm.description.links], axis=1)
        yield _compared("all links", ("walk", "pinocchio"), _walked(arm, theta) - theirs, theta, tolerance)


def _as_written(arm: Arm, theta: Array) -> Iterator[EngineComparison]:
    """Compare with Pinocchio's reading of the unchanged text."""
    if arm.description is None or why_no_pinocchio():
        return
    theta = _fewer(theta[:SLOW_SAMPLES], len(arm.description.links), USUAL_LINKS)
    try:
        theirs, written = as_written(arm.description, arm.joint_values(theta), arm.base)
    except InputError as error:
        yield _skipped("all links", AS_WRITTEN, str(error))
        return
    tolerance = WRITTEN_TOL * _size(arm)
    yield _compared("all links", ("walk", AS_WRITTEN), _walked(arm, theta) - theirs, theta, tolerance)
    bounds = [
        np.subtract(*np.clip([joint.hard, written[name]], -NO_LIMIT, NO_LIMIT)).tolist()
        for name, joint in arm.description.joints.items()
        if name in written and joint.type != "continuous" and joint.hard != (-np.inf, np.inf)
    ]
    if bounds:
        yield _compared("limits", ("tree", AS_WRITTEN), np.array([bounds]), theta[:1], tolerance)


def _yourdfpy(arm: Arm, theta: Array) -> Iterator[EngineComparison]:
    reason = "the arm has no description" if arm.description is None else beyond_yourdfpy(arm)
    if arm.description is None or reason:
        yield _skipped("all links", "yourdfpy", reason)
        return
    theta = _fewer(theta[:SLOW_SAMPLES], len(arm.description.links), YOURDFPY_LINKS)
    try:
        theirs = yourdfpy_poses(arm.description, arm.joint_values(theta), arm.base)
    except MissingExtraError as error:
        yield _skipped("all links", "yourdfpy", str(error))
        return
    except Exception as error:  # another project's reader: whatever it raises on a file is its answer
        yield _skipped("all links", "yourdfpy", f"yourdfpy cannot read it: {type(error).__name__}: {error}")
        return
    tip, tolerance = list(arm.description.links).index(arm.tip_link), YOURDFPY_TOL * _size(arm)
    at_tip = arm.by_exponentials(theta)[0] @ inverse(arm.tool) - theirs[:, tip]
    yield _compared("pose", ("poe", "yourdfpy"), at_tip, theta, tolerance)
    yield _compared("all links", ("walk", "yourdfpy"), _walked(arm, theta) - theirs, theta, tolerance)
    yield _skipped("Jacobians", "yourdfpy", "yourdfpy computes none")


def _skipped(quantity: str, engine: str, reason: str) -> EngineComparison:
    return EngineComparison(quantity, ("poe", engine), not_compared=reason)
