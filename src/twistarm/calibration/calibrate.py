"""`calibrate`: the arm's true axes and zeros, from measurements of its tool or from a camera."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import replace
from typing import Literal

import numpy as np

from ..arm.arm import Arm, require_arm
from ..support.checks import Array, as_flag, as_positive, as_theta, require, require_choice
from ..support.errors import InputError, listed, quote
from ..support.messages import Argument, Text
from ..support.units import theta_hint
from .calibration import Calibration
from .camera import Camera, Mount, refuse_unusable_views
from .geometry import BASE, JOINTS, TOOL, Geometry
from .measurements import LITTLE, Bools, Measurements, joined, read_measurements, require_metres
from .problem import OUTLIER, Problem, descend, observed, of_joints, started

Frame = Literal["fit", "held"]
Log = Measurements | str | os.PathLike[str]

FOLDS = 5
# How far joints are out as a rule [m, rad, 1]: what the fit knows before the log.
USUAL = {"zero": 0.2, "shift": 0.002, "tilt": 0.01, "scale": 0.1}
# A base that moved lowers the squares by more than so many times what six more parameters do by chance.
BASE_GAIN = 6.0
# An axis that would tilt by more [rad], or move by more reaches, is no matter of tolerances.
FAR_TILT, FAR_SHIFT = 0.2, 0.1
OTHER_CONVENTION = 0.2  # Orientations that are out by more [rad] are written in another convention.
LEAST_PART = 6  # Rows on each side of the moment when a base moved.


def calibrate(
    arm: Arm,
    measurements: Log | Sequence[Log],
    *,
    base: Frame = "fit",
    tool: Frame = "fit",
    position_noise: float = 1e-4,
    orientation_noise: float = 1e-3,
    distances: dict[tuple[str, str], float] | None = None,
    distance_noise: float = 1e-4,
    scales: bool = False,
    camera: Mount | None = None,
    tag_size: float | None = None,
    corner_noise: float = 8e-4,
) -> Calibration:
    """Fit an arm's axes and joint zeros to measurements of its tool, with base and tool beside them.

    The model is `geometry.Geometry`, a local product of exponentials. Each turning joint has 4 parameters and each
    slide 2; base and tool have 6 each. Zeros and scales come on top. A parameter that the log does not show beside the
    others is held at 0 and named. Base and tool come first, then zeros, then axes. Among these, what would show most
    at its usual size comes first. The choice follows from the nominal arm and the rows' configurations. Without
    positions or poses the base is the arm's own.

    Rows of `rvec` and `tvec` are a hand-eye calibration (`Calibration.hand_eye`). The camera is on the tool
    (eye-in-hand) or beside the arm (eye-to-hand). Its tag is at the other of these two places.
    Both poses come with the arm's zeros and axes from one fit of the reprojection error (`camera.Camera`).

    Args:
        arm: The nominal arm.
        measurements: A `Measurements`, the path of a CSV file (`read_measurements`), or several of them. Places of the
            same name are the same.
        base: "fit", or "held" where the positions are in the base frame.
        tool: "fit", or "held" where the measured point is the arm's tip.
        position_noise: Standard deviation of rows without their own [m].
        orientation_noise: Standard deviation of measured orientations [rad].
        distances: Known distances {(point, point): m} between resting points.
        distance_noise: Standard deviation of each of them [m].
        scales: Fit a scale of each joint's drive too.
        camera: "tool" (eye-in-hand) or "base" (eye-to-hand), where the log has rvec and tvec.
        tag_size: Side of the tag [m], as solvePnP had it.
        corner_noise: Standard deviation of a corner of the tag in the image, over the focal length [rad]. The default
            is 0.5 pixels at 600.

    Returns:
        The `Calibration`.

    Raises:
        InputError: The log is unusable: too few rows, angles in degrees, positions in millimetres. Before a camera
            the tool turns about one axis only.
    """
    require_arm(arm)
    for choice, name in ((base, "base"), (tool, "tool")):
        require_choice(choice, ("fit", "held"), name)
    log = _read(arm, measurements)
    noise = as_positive(position_noise, "position_noise"), as_positive(orientation_noise, "orientation_noise")
    known = _distances(distances, log), as_positive(distance_noise, "distance_noise")
    eye = _camera(log, camera, tag_size, as_positive(corner_noise, "corner_noise"))
    if eye is not None:
        if "held" in (base, tool) or distances:
            raise InputError("a camera's log shows base and tool as camera and tag: fit both, without distances")
        refuse_unusable_views(log, arm)
        noise, log = (eye.noise * float(np.median(log.tvec[:, 2])), noise[1]), eye.log(log)
    geometry = Geometry(arm, np.eye(4), np.eye(4), as_flag(scales, "scales"))
    prior = [0.0] * JOINTS + [1.0 / USUAL[parameter.what.split()[0]] for parameter in geometry.parameters[JOINTS:]]
    problem, start = Problem(geometry, log, noise, np.array(prior), *known, camera=eye).with_places()
    # Without a measured frame the base may not move, and only poses show how a tool is turned.
    fitted = np.ones(len(start), dtype=bool)
    fitted[BASE] = base == "fit" and bool(log.located.any())
    fitted[TOOL] = tool == "fit"
    fitted[TOOL][3:] &= bool(np.isfinite(log.rotation).any())
    return _fitted(problem, fitted, refuse_unusable(problem, fitted))


def _fitted(problem: Problem, fitted: Bools, odd: tuple[str, ...]) -> Calibration:
    """The fit of the `fitted` unknowns (Q,) that the log shows; `odd` is what is odd about the log."""
    problem, start = started(problem, bool(fitted[BASE].any()), fitted[TOOL])
    seen = observed(problem, start, fitted)
    still = still_joints(problem)
    if problem.camera is not None and still:  # camera and tag are as good without a corrected arm
        seen &= ~of_joints(problem)
        odd = (*odd, f"{listed(still)} hardly moves, so the arm is not corrected; move it by more than 15° or 50 mm")
    first = descend(problem, start, seen & ~of_joints(problem))[0]
    q, weights = descend(problem, first, seen)
    faults = faults_of(problem, q, first)
    held_out = np.inf, np.inf
    if not faults:
        loud = float(np.median(problem.normalised_residual(q)))
        if loud > OUTLIER:
            odd = (*odd, f"the rows fit {loud:.0f} times worse than the stated noise: something is not explained")
        held_out = _held_out(problem, first, seen)
    found = Calibration(problem, q, first, seen, fitted, weights, *held_out, (*odd, *faults), faults)
    return replace(found, unknowns=first) if found.sound else found


def _read(arm: Arm, measurements: Log | Sequence[Log]) -> Measurements:
    several = [measurements] if isinstance(measurements, (Measurements, str, os.PathLike)) else measurements
    if not isinstance(several, (list, tuple)) or not several:
        raise InputError(f"measurements must be a log, or a sequence of one log or more; got {quote(measurements)}")
    parts = [log if isinstance(log, Measurements) else read_measurements(log, arm) for log in several]
    for part in parts:
        as_theta(part.theta, arm.n, "theta", arm.joint_names)
    return joined(parts)


def _camera(log: Measurements, mount: Mount | None, tag_size: float | None, noise: float) -> Camera | None:
    """The camera of a log with rvec and tvec, or None. InputError where log and arguments do not agree."""
    given = {"camera": mount, "tag_size": tag_size}
    if not log.sighted.any():
        for name, value in given.items():
            if value is not None:
                raise InputError(Text("{name} needs a log with rvec and tvec", name=Argument(name)))
        return None
    if mount is None or tag_size is None:
        what = "the log has rvec and tvec of a tag: give {tool} (eye-in-hand) or {base} (eye-to-hand), and {size}"
        mounts = {name: Argument("camera", name) for name in ("tool", "base")}
        raise InputError(Text(what, **mounts, size=Argument("tag_size")))
    require_choice(mount, ("tool", "base"), "camera")
    size, depth = as_positive(tag_size, "tag_size"), float(np.median(np.abs(log.tvec[log.sighted, 2])))
    if size > 2.0 * depth:
        raise InputError(f"a tag of {size:.4g} m is larger than its distance, {depth:.3g} m: is it in mm?")
    return Camera(mount, size, noise)


def _distances(distances: dict[tuple[str, str], float] | None, log: Measurements) -> dict[tuple[str, str], float]:
    known = {}
    given = {} if distances is None else require(distances, dict, "distances", '{("left", "right"): 0.05}')
    for pair, length in given.items():
        if not isinstance(pair, tuple) or len(pair) != 2 or not set(pair) <= set(log.point) or pair[0] == pair[1]:
            points = listed(dict.fromkeys(filter(None, log.point))) or "none"
            raise InputError(f"distances join two points of the log ({points}); got {pair!r}")
        known[pair] = as_positive(length, f"distance of {pair}")
    return known


def _held_out(problem: Problem, first: Array, seen: Bools) -> tuple[float, float]:
    """The mean error [m] on rows left out, with all that the rest shows, and with base and tool alone.

    A fifth of the rows is left out in turn, at random. Without positions they are places, those with a known distance
    together, if there are several.

    Each fit begins at the unknowns with base and tool alone. A place that the rest does not have is fitted to the rows
    left out. The loudest percent of the rows does not count, because an outlier tells nothing of the arm. Infinity: a
    rest has no more numbers than unknowns.
    """
    K, P = len(problem.log.theta), problem.P
    fold = np.random.default_rng(0).permutation(K) % min(FOLDS, K)
    groups, of_row = np.unique(problem.group_of_row, return_inverse=True)
    if not problem.log.located.any() and len(groups) > 1:
        fold = of_row % FOLDS
    errors = np.full((2, K), np.nan)
    for left in (np.flatnonzero(fold == k) for k in np.unique(fold)):
        rest = problem.of_rows(np.setdiff1d(np.arange(K), left))
        own = np.zeros(len(first), dtype=bool)
        own[P:] = np.repeat(np.isin(np.arange(len(problem.places)), rest.place_of_row, invert=True), 3)
        free = observed(rest, first, seen & ~own)
        if rest.numbers <= free.sum():
            return np.inf, np.inf
        q = descend(rest, first, free & ~of_joints(problem))[0]
        for i, fitted in enumerate((descend(rest, q, free)[0], q)):
            errors[i, left] = problem.errors(descend(problem.of_rows(left), fitted, own)[0])[left]
    few = errors[1] <= np.nanquantile(errors[1], 0.99)
    return float(errors[0, few].mean()), float(errors[1, few].mean())


def refuse_unusable(problem: Problem, fitted: Bools) -> tuple[str, ...]:
    """InputError for a log that nothing can be fitted to; what else is odd, in words. `fitted` (Q,) may move."""
    log, arm = problem.log, problem.geometry.arm
    hint = theta_hint(log.theta, arm.units, arm.limits.lower, arm.limits.upper)
    if hint:
        raise InputError(f"{hint}: name the unit in the header, as in {arm.joint_names[arm.units.index('rad')]} [deg]")
    require_metres(log, arm)
    rows, numbers, least = len(log.theta), problem.numbers, int(fitted[:JOINTS].sum()) + 3 * len(problem.places)
    if numbers <= least:
        raise InputError(
            f"{rows} rows give {numbers} numbers; base, tool and places alone have {least} unknowns: measure more"
        )
    odd = []
    if numbers < 2 * fitted.sum():
        need = int(np.ceil(2 * fitted.sum() * rows / numbers))
        odd.append(f"{rows} rows are few for {fitted.sum()} unknowns: measure {need}, twice as many numbers")
    if not (log.located.any() or any(log.wire) or problem.distances):
        odd.append("points and planes alone do not show the arm's size: give the distance of two points, or positions")
    return tuple(odd)


def faults_of(problem: Problem, q: Array, first: Array) -> tuple[str, ...]:
    """What spoils the fit q (Q,): a joint at rest, an impossible correction, or a base that moved.

    `first` (Q,) are the unknowns with base and tool fitted alone.
    """
    arm, still = problem.geometry.arm, still_joints(problem)
    if still and problem.camera is None:
        return (f"{listed(still)} hardly moves: the fit holds near one value only; move it by more than 15° or 50 mm",)
    angles = np.linalg.norm(problem.misses(q)[problem.measured[:, 3], 3:], axis=1)
    if problem.camera is None and angles.size and np.median(angles) > OTHER_CONVENTION:
        return ("the orientations do not fit: are they qx, qy, qz, qw in this order, of the tool in device axes?",)
    # Before a camera wrong zeros alone turn the tag enough to look like a base that moved.
    moved = _moved_base(problem, q) or (() if problem.camera else _moved_base(problem, first))
    left = float(np.median(problem.errors(q)))
    axes = np.abs(problem.geometry.split(q[: problem.P])[3])
    tilt, shift = float(axes[:, 3:].max()), float(axes[:, :3].max())
    if moved or not (left > 0.03 * arm.reach or tilt > FAR_TILT or shift > FAR_SHIFT * arm.reach):
        return moved
    far = f"{1000 * left:.3g} mm are left, with axes moved by up to {np.degrees(tilt):.0f}° and {1000 * shift:.0f} mm"
    return (f"no arm fits these rows: {far}; are columns swapped, signs reversed, or units mixed?",)


def still_joints(problem: Problem) -> list[str]:
    """The joints that hardly move in the log."""
    arm, travel = problem.geometry.arm, np.ptp(problem.log.theta, axis=0)
    least = np.minimum([LITTLE[unit] for unit in arm.units], 0.5 * (arm.limits.upper - arm.limits.lower))
    return [name for name, moved, enough in zip(arm.joint_names, travel, least, strict=True) if moved < enough]


def _moved_base(problem: Problem, q: Array) -> tuple[str, ...]:
    """The row at which a rigid motion of the base explains the residuals best, if it explains much."""
    located = problem.log.located
    at, of = np.flatnonzero(located), np.nonzero(problem.measured)[0]  # the row of each number
    if len(at) < 4 * LEAST_PART:
        return ()
    # In standard deviations, as the fit: a camera measures depth and tilts far less well than the rest.
    here, ones, row = np.flatnonzero(located[of]), np.ones(len(located)), of[located[of]]
    r, A = problem.residual(q, ones)[here], problem.slopes(q, ones)[here, BASE]
    size = np.sqrt(np.bincount(row, r * r))
    r = r * np.minimum(1.0, np.quantile(size[at], 0.75) / np.maximum(size, 1e-12))[row]  # an outlier counts as others
    H, b = np.cumsum(A[:, :, None] * A[:, None], axis=0), np.cumsum(A * r[:, None], axis=0)
    cuts = np.unique(np.linspace(LEAST_PART, len(at) - LEAST_PART, 60).astype(int))
    ends = np.searchsorted(row, at[cuts]) - 1  # the last number before each cut
    gains = [
        b[c] @ np.linalg.lstsq(H[c], b[c], rcond=1e-9)[0]
        + (b[-1] - b[c]) @ np.linalg.lstsq(H[-1] - H[c], b[-1] - b[c], rcond=1e-9)[0]
        for c in ends
    ]
    best = int(np.argmax(gains))
    # What is left is at least the noise: less than that shows nothing.
    left = max((float(r @ r) - float(gains[best])) / len(r), 1.0)
    if gains[best] / 12 < BASE_GAIN * left or gains[best] < 0.3 * (r @ r):
        return ()
    near = problem.log.label[at[cuts[best]]]
    moved = "the base or the tracker" if problem.camera is None else "the camera or the tag"
    return (f"{moved} seems to have moved near {near}: calibrate with the rows before it, or with those after it",)
