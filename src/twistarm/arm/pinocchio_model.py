"""The only access to Pinocchio: model of a description, reference kinematics, inverse dynamics."""

from __future__ import annotations

import functools
import os
import tempfile
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np

from ..description.chain import Affine, coupling_matrix
from ..description.findings import refusal
from ..description.tree import Description
from ..support import wheels
from ..support.checks import Array
from ..support.errors import MissingExtraError

# Pinocchio's data holds four tensors of nv³ numbers: 0.12 GB here, and the doctor has two. The largest robot known,
# tiago_dual with two hands, has 101.
MAX_MOVING_JOINTS = 150
# `pinocchio` on the registry is another project.
_WHEEL = wheels.Wheel("pinocchio", "pin", has="buildModelFromXML", oldest="3.4")
_STDERR = threading.Lock()  # The process has one file descriptor 2, so only one redirection runs at a time.


class PinocchioModel:
    """Pinocchio's model of a whole description, with data for each thread.

    `coordinates` are theta's joints, `chain` the moving joints from base to tip. `q(theta)` gives every joint's value:
    the chain's from theta, mimic followers by their coupling, the others from `others` or 0. Continuous joints are
    revolute here, so q is one number per joint.
    """

    def __init__(
        self,
        description: Description,
        couplings: Mapping[str, Affine],
        coordinates: Sequence[str],
        chain: Sequence[str],
    ) -> None:
        self._pin = import_pinocchio()
        self.model = _build(description)
        self._local = threading.local()
        self._couplings = couplings
        self._coordinates = tuple(coordinates)
        self._index = {str(name): int(self.model.idx_qs[j]) for j, name in enumerate(self.model.names) if j > 0}
        self._A, self._b = coupling_matrix(self._couplings, list(self._index), self._coordinates)
        self._shifted = bool(self._b.any())
        self._same = not self._shifted and np.array_equal(self._A, np.eye(len(coordinates)))
        # What moves above the base carries base and tip alike: only the chain's joints move one against the other.
        self._A_chain = self._A * np.isin(np.arange(self.model.nq), [self._index[name] for name in chain])[:, None]
        body = self._pin.FrameType.BODY
        self._frames = {str(frame.name): i for i, frame in enumerate(self.model.frames) if frame.type == body}

    @property
    def data(self) -> Any:
        """Pinocchio's data, one for each thread."""
        if not hasattr(self._local, "data"):
            self._local.data = self._pin.Data(self.model)  # createData() would make it twice
        return self._local.data

    @property
    def dq_dtheta(self) -> Array:
        """(nq, n): how fast each joint of the model follows theta."""
        return self._A

    def frame_id(self, link: str) -> int:
        """Index of a link's frame. Pinocchio's look-up gives no error for an unknown name."""
        return self._frames[link]

    def q(self, theta: Array, other_joints: Mapping[str, float] | None = None) -> Array:
        """Pinocchio's configuration (nq,) for theta (n,) and joints outside the chain."""
        if self._same and not other_joints:
            return np.array(theta, dtype=np.float64)
        q: Array = self._A.dot(theta) + self._b if self._shifted else self._A.dot(theta)
        for name, value in (other_joints or {}).items():
            for joint, affine in self._couplings.items():
                if affine.master == name:
                    q[self._index[joint]] = affine.multiplier * value + affine.offset
        return q

    def joint_frames(self, q: Array) -> Array:
        """Position and rotation [p R] of each joint in the world at q (nq,), side by side: (3, 4 (njoints − 1)).

        They are the static regressor of a robot of mass 1. To read Pinocchio's poses one by one takes longer than the
        kinematics.
        """
        frames: Array = self._pin.computeStaticRegressor(self._of_mass_one, self.data, q)
        return frames

    @functools.cached_property
    def _of_mass_one(self) -> Any:
        model = self.model.copy()
        for j in range(model.njoints):
            model.inertias[j] = self._pin.Inertia(float(j == 1), np.zeros(3), np.zeros((3, 3)))
        return model

    def link_poses(self, configurations: Sequence[Array], base: str, links: Iterable[str]) -> dict[str, Array]:
        """Pose (N, 4, 4) of links in the frame of `base`, at N configurations q (nq,)."""
        data, poses = self.data, {link: np.empty((len(configurations), 4, 4)) for link in links}
        for row, q in enumerate(configurations):
            self._pin.framesForwardKinematics(self.model, data, q)
            base_world = data.oMf[self._frames[base]].inverse()
            for link, g in poses.items():
                g[row] = (base_world * data.oMf[self._frames[link]]).homogeneous
        return poses

    def kinematics(self, theta: Array, base: str, tip: str) -> tuple[Array, Array, Array]:
        """Pose (N, 4, 4) of `tip` in `base`, and its Jacobians J^s and J^b (N, 6, n), linear part first.

        J^s = Ad(g_root,base⁻¹) J_WORLD.
        """
        pin, model, data = self._pin, self.model, self.data
        at_base, at_tip, frames = self._frames[base], self._frames[tip], pin.ReferenceFrame
        g, spatial, body = (np.empty((len(theta), *shape)) for shape in ((4, 4), (6, model.nv), (6, model.nv)))
        for row, q in enumerate(theta @ self._A.T + self._b):
            pin.computeJointJacobians(model, data, q)  # with the forward kinematics
            world_base = pin.updateFramePlacement(model, data, at_base)
            g[row] = world_base.actInv(pin.updateFramePlacement(model, data, at_tip)).homogeneous
            # A model with one joint has Jacobians of shape (6,).
            J = pin.getFrameJacobian(model, data, at_tip, frames.WORLD).reshape(6, -1)
            spatial[row] = world_base.toActionMatrixInverse() @ J
            body[row] = pin.getFrameJacobian(model, data, at_tip, frames.LOCAL).reshape(6, -1)
        return g, spatial @ self._A_chain, body @ self._A_chain

    @property
    def moved_mass(self) -> float:
        """The mass [kg] of all bodies that theta moves."""
        moving = np.append(False, self._A.any(axis=1))  # the universe is joint 0
        return sum(
            float(body.mass)
            for body, above in zip(self.model.inertias, self.model.supports, strict=True)
            if moving[list(above)].any()
        )

    def inverse_dynamics(
        self, motion: Sequence[Array], base: str, gravity: Array, link: str, load: tuple[float, Array]
    ) -> Array:
        """Joint efforts (N, n) of theta and its first two rates (N, n), by the recursive Newton-Euler algorithm.

        `gravity` (3,) is in axes of `base`. `load` is a point mass on `link` and its place (3,).
        """
        if not hasattr(self._local, "model"):  # one for each thread, because it keeps gravity and bodies
            self._local.model = self.model.copy()
        model, data, frame = self._local.model, self.data, self.model.frames[self._frames[link]]
        body = frame.placement.act(self._pin.Inertia(load[0], load[1], np.zeros((3, 3))))
        model.inertias[frame.parentJoint] = self.model.inertias[frame.parentJoint] + body
        torques = np.zeros((len(motion[0]), len(self._A)))
        root = model.frames[self._frames[base]]
        model.gravity.linear = root.placement.rotation @ gravity
        for row, (q, v, a) in enumerate(zip(*(x @ self._A.T for x in motion), strict=True)):
            q = q + self._b
            if root.parentJoint:  # a joint above the base turns it
                self._pin.forwardKinematics(model, data, q)
                world_base = self._pin.updateFramePlacement(model, data, self._frames[base])
                model.gravity.linear = world_base.rotation @ gravity
            torques[row] = self._pin.rnea(model, data, q, v, a)
        return torques @ self._A


def import_pinocchio() -> Any:
    """The module of the `pin` wheel. Otherwise raise TwistarmError with the cause and the remedy."""
    return wheels.load(_WHEEL)


@functools.cache
def why_no_pinocchio() -> str:
    """How to install Pinocchio. Empty if it is installed."""
    try:
        import_pinocchio()
    except MissingExtraError as missing:
        return str(missing)
    return ""


def model_of(text: str) -> tuple[Any, str]:
    """The model of a URDF text and an empty text, or None and the message of Pinocchio's parser."""
    pin = import_pinocchio()
    with _captured_stderr() as complaint:
        try:
            return pin.buildModelFromXML(text), ""
        except (ValueError, RuntimeError) as error:
            return None, " ".join(complaint().split()) or str(error)


def _build(description: Description) -> Any:
    count = sum(joint.moving for joint in description.joints.values())
    if count > MAX_MOVING_JOINTS:
        what = f"{count} moving joints; at most {MAX_MOVING_JOINTS}"
        raise refusal("too-large", description.place(), what, "is it a whole scene?")
    model, complaint = model_of(description.repaired)
    if complaint:
        raise refusal(
            "engines-disagree", description.place(), f"Pinocchio refuses it: {complaint}", "correct what it names"
        )
    return model


@contextmanager
def _captured_stderr() -> Iterator[Callable[[], str]]:
    """Capture the C++ stderr as text. Pinocchio's parser writes the cause of an error only there."""
    with _STDERR, tempfile.TemporaryFile() as file:
        try:
            saved = os.dup(2)
        except OSError:  # a process without a stderr has nothing to capture
            yield str
            return
        os.dup2(file.fileno(), 2)

        def text() -> str:
            file.seek(0)
            return file.read().decode("utf-8", "replace")

        try:
            yield text
        finally:
            os.dup2(saved, 2)
            os.close(saved)
