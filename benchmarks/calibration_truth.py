"""Arms that stand a little elsewhere, what an instrument measures of them, and how near a calibration comes.

The truth is a product of exponentials with moved axes, made here. The calibration knows only the log.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np

from twistarm import Arm, arm_from_screws, joints, load_arm
from twistarm.calibration import Calibration, Measurements, calibrate
from twistarm.theory import poe
from twistarm.theory.rotations import exp as turn
from twistarm.theory.screws import adjoint, exp, to_screw

from .servo_arms import MODELS, servo_arm

Array = np.ndarray[Any, np.dtype[np.float64]]

SHIFT, TILT = 1e-3, np.radians(0.2)
"""One standard deviation of an axis's place and direction [m, rad]; a zero is off as a direction is."""

APART = 0.05
"""Distance of the sockets of a pair [m]."""

POSITION, ORIENTATION = 1e-4, 1e-3
"""One standard deviation of what is measured [m, rad]."""

NAMED = ("rover_arm", "scara", "stanford", "ur5", "panda", "so101", "xarm7")
KINDS = ("positions", "poses", "sockets", "planes", "wires", "mixed")

MIMIC = """<robot name="mimic">{links}
{joints}</robot>"""


def mimic_arm(folder: Path) -> Arm:
    """A turning base, a lift whose forearm turns back half as much, an elbow, and two turns of a wrist."""
    rows = (
        ("pan", "0 0 0.1", "0 0 1", ""), ("lift", "0.05 0 0.1", "0 1 0", ""),
        ("follower", "0 0 0.3", "0 1 0", '<mimic joint="lift" multiplier="-0.5"/>'),
        ("elbow", "0.05 0 0.25", "0 1 0", ""), ("roll", "0.2 0 0", "1 0 0", ""), ("pitch", "0.1 0 0", "0 1 0", ""),
    )  # fmt: skip
    links = "".join(f'<link name="l{i}"/>' for i in range(len(rows) + 1))
    made = "".join(
        f'<joint name="{name}" type="revolute"><parent link="l{i}"/><child link="l{i + 1}"/><origin xyz="{xyz}"/>'
        f'<axis xyz="{axis}"/><limit lower="-2.5" upper="2.5" velocity="1" effort="1"/>{inside}</joint>\n'
        for i, (name, xyz, axis, inside) in enumerate(rows)
    )
    file = folder / "mimic.urdf"
    file.write_text(MIMIC.format(links=links, joints=made), encoding="utf-8")
    tip = np.eye(4)
    tip[:3, 3] = 0.1, 0.02, 0.03
    return load_arm(file).with_tool(tip, "tip")


def parallel_wrist() -> Arm:
    """Six turns, the axes of joints 3, 4 and 5 parallel."""
    x, y, z = np.eye(3)
    axes = (
        (z, 0, 0, 0),
        (x, 0, 0, 0.3),
        (y, 0.1, 0, 0.4),
        (y, 0.5, 0.05, 0.4),
        (y, 0.8, 0.1, 0.4),
        (z, 0.85, 0.1, 0.3),
    )
    home = np.eye(4)
    home[:3, 3] = 0.9, 0.15, 0.3
    return arm_from_screws(np.column_stack([joints.revolute(w, p) for w, *p in axes]), home, name="parallel 3-4-5")


def arms(folder: Path) -> dict[str, Callable[[], Arm]]:
    """What is calibrated: 5 to 7 joints, slides, continuous joints, a mimic joint, parallel axes."""
    named: dict[str, Callable[[], Arm]] = {name: lambda name=name: load_arm(name) for name in NAMED}  # type: ignore[misc]
    named |= {"mimic": lambda: mimic_arm(folder), "parallel 3-4-5": parallel_wrist}
    return named | {name: lambda name=name: servo_arm(name) for name in MODELS}  # type: ignore[misc]


@dataclass(frozen=True)
class Truth:
    """An arm as it is: screws (6, m) and home of moved axes, zeros (n,), base and tool of the measurement (4, 4)."""

    arm: Arm
    screws: Array
    home: Array
    zeros: Array
    base: Array
    tool: Array

    def poses(self, theta: Array) -> Array:
        """What an exact instrument would measure at theta (K, n)."""
        return self.base @ poe.fk(self.screws, self.home, (theta + self.zeros) @ self.arm.coupling.A.T) @ self.tool


def truth_of(arm: Arm, rng: np.random.Generator, size: float = 1.0, in_base: bool = False) -> Truth:
    """Every axis moved across itself, every zero off; a base anywhere, or the arm's own; a tool roughly known."""
    screws, point = arm.screws.copy(), np.zeros(3)
    for i, xi in enumerate(arm.screws.T):
        screw = to_screw(xi)
        if np.linalg.norm(xi[3:]) > 1e-9:
            point = screw.point + screw.axis * (screw.axis @ (point - screw.point))
        across = np.linalg.svd(screw.axis[None])[2][1:]  # (2, 3)
        shift, tilt = size * rng.normal(scale=[[SHIFT], [TILT]], size=(2, 2)) @ across
        moved = np.r_[shift + np.cross(point, tilt), tilt]  # turns about the point, then shifts
        screws[:, i] = adjoint(exp(moved)) @ xi
    home = exp(size * rng.normal(scale=[SHIFT] * 3 + [TILT] * 3)) @ arm.home
    zeros = size * rng.normal(scale=np.where(np.array(arm.units) == "m", SHIFT, TILT))
    base, tool = np.eye(4), exp(np.r_[rng.normal(scale=0.02, size=3), rng.normal(scale=0.05, size=3)])
    if not in_base:
        base[:3, :3], base[:3, 3] = turn(rng.normal(size=3)), rng.normal(size=3)
    return Truth(arm, screws, home, zeros, base, tool)


def postures(truth: Truth, miss: Callable[[Array], Array], count: int, rng: np.random.Generator) -> Array:
    """Configurations (count, n) inside the limits whose tool point p (K, 3) has miss(p) = 0, by Gauss-Newton."""
    arm, found, h = truth.arm, [np.empty((0, truth.arm.n))], 1e-6
    lower, upper = np.maximum(arm.limits.lower, -np.pi), np.minimum(arm.limits.upper, np.pi)
    for _ in range(40):
        theta = arm.random_theta(rng, 4 * count)
        for _ in range(25):
            r = miss(truth.poses(theta)[:, :3, 3])
            J = np.stack([miss(truth.poses(theta + h * e)[:, :3, 3]) - r for e in np.eye(arm.n)], axis=-1) / h
            step = -np.linalg.pinv(J, rcond=1e-3) @ r[..., None]
            theta = np.clip(theta + np.clip(step[..., 0], -0.3, 0.3), lower, upper)
        found.append(theta[np.abs(miss(truth.poses(theta)[:, :3, 3])).max(axis=1) < 1e-9])
        if sum(map(len, found)) >= count:
            return np.concatenate(found)[:count]
    raise ValueError(f"{arm.name} does not reach often enough")


def _log(theta: Array, **measured: Any) -> dict[str, Any]:
    K = len(theta)
    empty = {"position": np.full((K, 3), np.nan), "rotation": np.full((K, 3, 3), np.nan), "length": np.full(K, np.nan)}
    names = dict.fromkeys(("point", "plane", "wire"), ("",) * K)
    return {"theta": theta} | empty | names | measured


def _joined(parts: list[dict[str, Any]]) -> Measurements:
    arrays = {key: np.concatenate([part[key] for part in parts]) for key in ("theta", "position", "rotation", "length")}
    names = {key: sum((tuple(part[key]) for part in parts), ()) for key in ("point", "plane", "wire")}
    return Measurements(**arrays, **names)


def positions_log(truth: Truth, count: int, rng: np.random.Generator, turned: bool = False) -> dict[str, Any]:
    theta = truth.arm.random_theta(rng, count)
    g = truth.poses(theta)
    measured = {"position": g[:, :3, 3] + rng.normal(scale=POSITION, size=(count, 3))}
    if turned:
        measured["rotation"] = g[:, :3, :3] @ turn(rng.normal(scale=ORIENTATION, size=(count, 3)))
    return _log(theta, **measured)


def resting_log(
    truth: Truth, kind: str, name: str, miss: Callable[[Array], Array], count: int, rng: np.random.Generator
) -> dict[str, Any]:
    """The tool at rest at a "point", on a "plane": postures that miss it by the noise of the instrument."""
    exact, h = postures(truth, miss, count, rng), 1e-6
    r = miss(truth.poses(exact)[:, :3, 3])
    J = np.stack([miss(truth.poses(exact + h * e)[:, :3, 3]) - r for e in np.eye(truth.arm.n)], axis=-1) / h
    noise = rng.normal(scale=POSITION, size=r.shape)
    theta = exact + (np.linalg.pinv(J, rcond=1e-3) @ noise[..., None])[..., 0]
    return _log(theta, **{kind: (name,) * count})


def sockets_log(
    truth: Truth, pairs: int, count: int, rng: np.random.Generator
) -> tuple[list[dict[str, Any]], dict[tuple[str, str], float]]:
    """A ball in pairs of sockets 50 mm apart, and their distances."""
    logs, distances = [], {}
    for k, place in enumerate(spots(truth, pairs, rng)):
        names = f"left {k}", f"right {k}"
        aside = rng.normal(size=3)
        for name, at in zip(names, (place, place + APART * aside / np.linalg.norm(aside)), strict=True):
            logs.append(resting_log(truth, "point", name, lambda p, at=at: p - at, count, rng))  # type: ignore[misc]
        distances[names] = APART
    return logs, distances


def planes_log(truth: Truth, planes: int, count: int, rng: np.random.Generator) -> list[dict[str, Any]]:
    logs = []
    for k, place in enumerate(spots(truth, planes, rng)):
        normal = np.linalg.qr(rng.normal(size=(3, 3)))[0][0]
        logs.append(
            resting_log(truth, "plane", f"plane {k}", lambda p, n=normal, at=place: ((p - at) @ n)[:, None], count, rng)
        )  # type: ignore[misc]
    return logs


def wires_log(truth: Truth, anchors: int, count: int, rng: np.random.Generator) -> list[dict[str, Any]]:
    logs = []
    for k in range(anchors):
        theta, anchor = (
            truth.arm.random_theta(rng, count),
            truth.base[:3, 3] + rng.normal(scale=truth.arm.reach, size=3),
        )
        length = np.linalg.norm(truth.poses(theta)[:, :3, 3] - anchor, axis=1) + rng.normal(scale=POSITION, size=count)
        logs.append(_log(theta, wire=(f"nail {k}",) * count, length=length))
    return logs


def spots(truth: Truth, count: int, rng: np.random.Generator) -> Array:
    """Places (count, 3) well inside the workspace, in the frame of the instrument."""
    p = truth.poses(truth.arm.random_theta(rng, 2000))[:, :3, 3]
    centre = truth.base[:3, 3]
    far = np.linalg.norm(p - centre, axis=1)
    inside = p[(far > np.quantile(far, 0.2)) & (far < np.quantile(far, 0.75))]
    return np.asarray(inside[rng.choice(len(inside), count, replace=False)])


def measured(truth: Truth, kind: str, rng: np.random.Generator) -> tuple[Measurements, dict[tuple[str, str], float]]:
    """A log of that kind, and the known distances."""
    if kind in ("positions", "poses"):
        return _joined([positions_log(truth, 60, rng, turned=kind == "poses")]), {}
    if kind == "sockets":
        logs, distances = sockets_log(truth, 3, 25, rng)
        return _joined(logs), distances
    if kind == "planes":
        return _joined(planes_log(truth, 6, 40, rng)), {}
    if kind == "wires":
        return _joined(wires_log(truth, 4, 50, rng)), {}
    logs, distances = sockets_log(truth, 1, 15, rng)
    return _joined(
        [positions_log(truth, 30, rng), *logs, *planes_log(truth, 1, 20, rng), *wires_log(truth, 1, 20, rng)]
    ), distances


@dataclass(frozen=True)
class Score:
    """One log, judged.

    `off` is the root mean square error of a coordinate on new postures, in standard deviations of the noise; `nominal`
    that of the nominal arm. Both after the rigid motion that fits best where the log has no measured frame. `ratio` is
    the least and the largest stated deviation over that of finite differences. `claimed` are numbers called seen that
    the others explain, or whose deviation is above 20 mm or mrad.
    """

    off: float
    nominal: float
    seen: int
    ratio: tuple[float, float]
    claimed: tuple[str, ...]
    confirmed: bool
    faults: tuple[str, ...]
    seconds: float


def aligned(a: Array, b: Array) -> Array:
    """a (K, 3) moved as a rigid body to b."""
    g = kabsch(a, b)
    return np.asarray(a @ g[:3, :3].T + g[:3, 3])


def kabsch(a: Array, b: Array) -> Array:
    """The rigid motion (4, 4) that takes points a (K, 3) nearest to b."""
    ca, cb = a.mean(axis=0), b.mean(axis=0)
    U, _, Vt = np.linalg.svd((b - cb).T @ (a - ca))
    g = np.eye(4)
    g[:3, :3] = U @ np.diag([1, 1, np.linalg.det(U @ Vt)]) @ Vt
    g[:3, 3] = cb - g[:3, :3] @ ca
    return g


def score(arm: Arm, kind: str, seed: int) -> Score:
    rng = np.random.default_rng(seed)
    located = kind in ("positions", "poses", "mixed")
    truth = truth_of(arm, rng, in_base=not located)
    log, distances = measured(truth, kind, rng)
    begin = process_time()
    r = calibrate(
        arm, log, position_noise=POSITION, orientation_noise=ORIENTATION, distances=distances or None
    )  # fmt: skip
    seconds = process_time() - begin
    fresh = arm.random_theta(seed + 1000, 400)
    exact, nominal = truth.poses(fresh)[:, :3, 3], (arm.fk(fresh) @ truth.tool)[:, :3, 3]
    found = r.predict(fresh) if located else aligned(r.predict(fresh), exact)
    off, off_nominal = (
        float(np.sqrt(((p - exact) ** 2).mean())) / POSITION for p in (found, aligned(nominal, exact))
    )  # fmt: skip
    ratio, claimed = judged(r)
    return Score(off, off_nominal, sum(e.seen for e in r.estimates), ratio, claimed, r.confirmed, r.faults, seconds)


def judged(r: Calibration) -> tuple[tuple[float, float], tuple[str, ...]]:
    """Stated deviations over those of finite differences, and numbers that the log does not show beside the others."""
    ones, h = np.ones(len(r.problem.log.theta)), 1e-6
    seen = [j for j, each in enumerate(r.estimates) if each.seen]
    steps = h * np.eye(len(r.estimates))[seen]
    q = r.unknowns
    ends = [(r.problem.residual(q + d, ones), r.problem.residual(q - d, ones)) for d in steps]
    A = np.stack([(after - before) / (2 * h) for after, before in ends], axis=1)
    size = np.linalg.norm(A, axis=0)
    across = 1.0 / np.linalg.norm(np.linalg.pinv(A / size, rcond=1e-12), axis=1)
    std = 1.0 / (across * size)
    stated = np.array([r.estimates[j].std for j in seen]) / std
    wrong = [str(r.estimates[j].parameter) for j, c, s in zip(seen, across, std, strict=True) if c < 1e-6 or s > 0.02]
    return (float(stated.min()), float(stated.max())), tuple(wrong)


def truth_at_zero(arm: Arm, kind: str, seed: int) -> tuple[Array, int]:
    """Deviations (value − truth)/σ of the joints' numbers, where the truth has 0 in what the log does not show.

    The truth is what a first log gave, so it lies in the chosen numbers; a second log of the same postures is judged.
    Also the count of numbers that only one of the two logs chose: with another choice the values mean something else.
    """
    rng = np.random.default_rng(seed)
    truth = truth_of(arm, rng)
    log = positions_log(truth, 60, rng, turned=kind == "poses")
    noises = {"position_noise": POSITION, "orientation_noise": ORIENTATION}
    first = calibrate(arm, _joined([log]), **noises)  # type: ignore[arg-type]
    g = first.problem.geometry.poses(first.unknowns[: first.problem.P], log["theta"])
    log["position"] = g[:, :3, 3] + rng.normal(scale=POSITION, size=(60, 3))
    if kind == "poses":
        log["rotation"] = g[:, :3, :3] @ turn(rng.normal(scale=ORIENTATION, size=(60, 3)))
    second = calibrate(arm, _joined([log]), **noises)  # type: ignore[arg-type]
    pairs = list(zip(first.estimates, second.estimates, strict=True))[12:]
    z = [(b.value - a.value) / b.std for a, b in pairs if b.seen]
    return np.array(z), sum(a.seen != b.seen for a, b in pairs)
