"""A camera that sees a tag: hand-eye calibration, its reprojection error, first guess and result."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from ..arm.arm import Arm
from ..support.checks import Array, nearest_rotation
from ..support.errors import InputError
from ..support.messages import Argument, Text
from ..theory.rotations import exp as rotation
from ..theory.rotations import log_of, skew, to_rpy
from ..theory.screws import inverse_of
from .measurements import Bools, Measurements, Rows

Mount = Literal["tool", "base"]

NEAR = 0.1  # A corner nearer to the image plane than this share of the tag's side is drawn there: no division by 0.
MOST_PAIRS = 4000  # More pairs of rows do not improve a first guess.
ONE_AXIS = 0.05  # Root mean square [rad] of turns about a second axis below which the tool turned about one at most.
INVERTED = 3.0  # Poses that fit so much worse than their inverses are those. Wrong zeros alone reach 1.


@dataclass(frozen=True)
class Camera:
    """A camera on the tool (eye-in-hand) or beside the arm (eye-to-hand), and a square tag of side `tag_size` [m].

    Its rows are poses M = B g T like all others. On the tool T is the camera beyond the tip, and M the camera in the
    tag's frame. Beside the arm T is the tag beyond the tip, and M the tag in the camera's frame.

    The residual is the reprojection error: the tag's corners in the image, (x/z, y/z), by the model minus those by the
    measured pose. `noise` [rad] is its standard deviation: that of a corner in pixels over the focal length. A pose of
    solvePnP has six degrees of freedom. So the error is projected onto the six directions in which the measured pose
    moves the corners. Depth and tilts then weigh as little as the corners show them.
    """

    mount: Mount
    tag_size: float
    noise: float

    @property
    def corners(self) -> Array:
        """The corners (4, 3) [m] in the tag's frame, the origin at its centre."""
        return np.array([[-1, 1, 0], [1, 1, 0], [1, -1, 0], [-1, -1, 0]]) * (self.tag_size / 2)

    def log(self, log: Measurements) -> Measurements:
        """The rows as poses M (K, 4, 4): `position` and `rotation` instead of `rvec` and `tvec`."""
        R, p = rotation(log.rvec), log.tvec
        if self.mount == "tool":
            R = np.swapaxes(R, 1, 2)
            p = -(R @ p[..., None])[..., 0]
        empty = np.empty(0)
        return replace(log, position=p, rotation=R, rvec=empty, tvec=empty)

    def image(self, M: Array) -> tuple[Array, Array]:
        """The corners (K, 8) in the image of poses M (K, 4, 4), and their slopes (K, 8, 6) by M's position and turn."""
        R, p = M[:, None, :3, :3], M[:, None, :3, 3]
        if self.mount == "base":
            lever = (R @ self.corners[:, :, None])[..., 0]
            x = lever + p
            slope = np.concatenate([np.broadcast_to(np.eye(3), (*lever.shape, 3)), -skew(lever)], axis=-1)
        else:
            back, lever = np.swapaxes(R, -1, -2), self.corners - p
            x = (back @ lever[..., None])[..., 0]
            slope = np.concatenate([np.broadcast_to(-back, (*lever.shape, 3)), back @ skew(lever)], axis=-1)
        z = np.maximum(x[..., 2:], NEAR * self.tag_size)
        u = x[..., :2] / z
        slope = (slope[..., :2, :] - u[..., None] * slope[..., 2:, :]) / z[..., None]
        return u.reshape(len(M), 8), slope.reshape(len(M), 8, 6)

    def measured(self, log: Measurements) -> tuple[Array, Array]:
        """The corners (K, 8) of the measured poses, and the directions (K, 8, 6) in which these move them."""
        u, slope = self.image(poses_of(log))
        return u, np.linalg.qr(slope)[0]

    def in_camera(self, M: Array) -> Array:
        """The tag in the camera's frame (K, 4, 4), for poses M."""
        return M if self.mount == "base" else inverse_of(M)

    def visible(self, M: Array, log: Measurements) -> Bools:
        """Whether the tag at M (N, 4, 4) is as near, as central and as steep in the image as in the log."""

        def view(poses: Array) -> Array:
            tag = self.in_camera(poses)
            p = tag[:, :3, 3]
            facing = (tag[:, :3, 2] * p).sum(axis=1) / np.linalg.norm(p, axis=1)
            return np.stack([p[:, 2], np.hypot(p[:, 0], p[:, 1]) / np.abs(p[:, 2]), facing], axis=1)

        seen = view(poses_of(log))
        least, most = seen.min(axis=0), seen.max(axis=0)
        least[1] = 0.0
        return np.asarray(((view(M) >= least) & (view(M) <= most)).all(axis=1))


def poses_of(log: Measurements) -> Array:
    """The measured poses (K, 4, 4)."""
    M = np.tile(np.eye(4), (len(log.theta), 1, 1))
    M[:, :3, :3], M[:, :3, 3] = log.rotation, log.position
    return M


def refuse_unusable_views(log: Measurements, arm: Arm) -> None:
    """InputError for rows that solvePnP does not return: other units or kinds, a tag behind the camera."""
    if not log.sighted.all() or np.isfinite(log.noise).any():
        raise InputError("all rows of a camera's log hold rvec and tvec, and no noise: fit other measurements alone")
    turn, far = np.linalg.norm(log.rvec, axis=1), log.tvec[:, 2]
    if turn.max() > 2 * np.pi:
        raise InputError(
            f"{log.label[turn.argmax()]}: rvec has length {turn.max():.4g} rad: name the unit, as rx [deg]"
        )
    if (size := float(np.median(np.abs(far)))) > 20.0 * arm.reach:
        raise InputError(
            f"the tag is {size:.4g} m from the camera, and the arm reaches {arm.reach:.3g} m: name the unit, as tx [mm]"
        )
    if (far <= 0.0).any():
        count, k = int((far <= 0.0).sum()), int((far <= 0.0).argmax())
        raise InputError(
            f"{log.label[k]}: tz = {far[k]:.4g} m, so the tag is behind the camera ({count} of {len(far)} rows); "
            "give rvec and tvec of the tag in the camera, as solvePnP returns them, or leave such rows out"
        )


def first_guess(g: Array, M: Array, mount: Mount) -> tuple[Array, Array]:
    """B and T (4, 4) with M ≈ B g T (K, 4, 4), for a start: rotations first, then positions.

    Turns between two rows have the rotation vectors α = R_B β: R_B by Park & Martin 1994, over all pairs. R_T is then a
    mean rotation, and the positions are linear. Cauchy's weights let a flipped tag count for little.

    Raises:
        InputError: The tool turns about one axis only, or the poses are the inverse ones.
    """
    i, j = np.triu_indices(len(g), 1)
    if len(i) > MOST_PAIRS:
        chosen = np.random.default_rng(0).choice(len(i), MOST_PAIRS, replace=False)
        i, j = i[chosen], j[chosen]
    beta = log_of(g[i, :3, :3] @ np.swapaxes(g[j, :3, :3], 1, 2))
    if np.linalg.svd(beta / np.sqrt(len(beta)), compute_uv=False)[1] < ONE_AXIS:
        raise InputError(
            "the tool turns about one axis at most, so this log shows neither camera nor tag: turn the tool about two "
            "axes, by 30° and more"
        )
    (B, T, left), (_, _, left_by_inverse) = (_fit(g, poses, beta, (i, j)) for poses in (M, inverse_of(M)))
    if left_by_inverse < left / INVERTED:
        other = Argument("camera", "base" if mount == "tool" else "tool")
        what = "the inverse poses fit: give {other}, or rvec and tvec of the tag in the camera, as of solvePnP"
        raise InputError(Text(what, other=other))
    return B, T


def _fit(g: Array, M: Array, beta: Array, pairs: tuple[Rows, Rows]) -> tuple[Array, Array, float]:
    """B and T (4, 4), and the product of the median misfits of orientation and position [rad m]."""
    i, j = pairs
    alpha = log_of(M[i, :3, :3] @ np.swapaxes(M[j, :3, :3], 1, 2))
    R_B, R_T, weights, misfit = _rotations(g, M[:, :3, :3], alpha, beta, pairs)
    # p_M = R_B (R_g t_T + p_g) + t_B is linear in t_T and t_B.
    A = np.concatenate([R_B @ g[:, :3, :3], np.broadcast_to(np.eye(3), (len(g), 3, 3))], axis=2)
    b, w = M[:, :3, 3] - g[:, :3, 3] @ R_B.T, np.sqrt(weights)[:, None]
    t = np.linalg.lstsq((A * w[..., None]).reshape(-1, 6), (b * w).ravel(), rcond=None)[0]
    B, T = np.eye(4), np.eye(4)
    T[:3, :3], T[:3, 3], B[:3, :3], B[:3, 3] = R_T, t[:3], R_B, t[3:]
    return B, T, misfit * float(np.median(np.linalg.norm(A @ t - b, axis=1)))


def _rotations(
    g: Array, R: Array, alpha: Array, beta: Array, pairs: tuple[Rows, Rows]
) -> tuple[Array, Array, Array, float]:
    """R_B, R_T, the weights (K,) of the rows, and the median misfit [rad]."""
    weights, Rg = np.ones(len(g)), g[:, :3, :3]
    for _ in range(10):
        w = weights[pairs[0]] * weights[pairs[1]]
        R_B, _ = nearest_rotation((alpha * w[:, None]).T @ beta)
        R_T, _ = nearest_rotation((weights[:, None, None] * (np.swapaxes(R_B @ Rg, 1, 2) @ R)).sum(axis=0))
        misses = np.linalg.norm(log_of(np.swapaxes(R, 1, 2) @ R_B @ Rg @ R_T), axis=1)
        misfit = float(np.median(misses))
        weights = 1.0 / (1.0 + (misses / max(3.0 * misfit, 1e-9)) ** 2)
    return R_B, R_T, weights, misfit


@dataclass(frozen=True, eq=False)
class HandEye:
    """The result of a hand-eye calibration.

    `camera` (4, 4) is the camera's optical frame in the link `parent`: the tip's for a camera on the tool, else the
    base's. `tag` (4, 4) is the tag in the other link, `tag_parent`. `camera_std` and `tag_std` are the standard
    deviations of position and orientation, √(tr C), [m, rad]. They are infinite where the log does not determine it.

    `residual` are the medians of the tag's position and orientation in the camera, measured against computed [m, rad].
    `corrected`: they belong to the corrected arm, because rows left out confirm it; else to the arm as described.

    A turn of the first joint's zero moves what stands beside the base. One of the last joint's moves what the tool
    carries. No log shows them: these zeros stay, and `camera` and `tag` take them in.
    """

    camera: Array
    camera_std: tuple[float, float]
    parent: str
    tag: Array
    tag_std: tuple[float, float]
    tag_parent: str
    residual: tuple[float, float]
    corrected: bool

    @property
    def determined(self) -> bool:
        """Whether the log shows the whole camera and the whole tag."""
        return bool(np.isfinite([*self.camera_std, *self.tag_std]).all())

    @property
    def urdf(self) -> str:
        """The camera's link and fixed joint, to paste into the URDF."""
        parts = self.camera[:3, 3], to_rpy(self.camera[:3, :3])
        xyz, rpy = (" ".join(f"{x:.6f}" for x in part + 0.0) for part in parts)
        return (
            '<link name="camera_optical_frame"/>\n'
            '<joint name="camera_joint" type="fixed">\n'
            f'  <parent link="{self.parent}"/>\n'
            '  <child link="camera_optical_frame"/>\n'
            f'  <origin xyz="{xyz}" rpy="{rpy}"/>\n'
            "</joint>"
        )
