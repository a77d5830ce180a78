"""One library that calibrates arms, in its own environment. `python -m benchmarks.calibration_worker PEER`.

It reads one JSON object per line and answers with one line each, as `worker.py` does:

  {"do": "fit", "arm", "screws", "home", "theta", "positions", "asked"}          {"predicted", "ns"} or {"error"}

  {"do": "hand_eye", "seed", "side", "tags", "g"}                                {"rvec", "tvec", "found"} or {"error"}

`screws` and `home` are the nominal arm with the tool's point as its tip, and `positions` (K, 3) [m] are seen from its
base: base and tool come from a fit of these rows. `predicted` are the positions at `asked` (N, n). `ns` is processor
time.

`tags` (K, 4, 4) are true poses of a tag of that `side` [m] in the camera, whose image has 0.5 pixels of noise, and `g`
(K, 4, 4) the arm's. `rvec` and `tvec` are those of solvePnP, and `found` the pose by every method of calibrateHandEye.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from time import process_time_ns
from typing import Any

import numpy as np

from .peers import serve

Asked = dict[str, Any]


def twistarm(asked: Asked) -> Callable[[np.ndarray], np.ndarray]:
    from twistarm import load_arm
    from twistarm.calibration import Measurements, calibrate

    return calibrate(
        load_arm(asked["arm"]), Measurements(np.array(asked["theta"]), np.array(asked["positions"]))
    ).predict


def robotkinecal(asked: Asked) -> Callable[[np.ndarray], np.ndarray]:
    import roboticstoolbox as rtb
    from robotkinecal import SerialRobotKineCal
    from spatialmath import SE3, Twist3

    screws = np.array(asked["screws"])
    axes = [(xi[3:], np.cross(xi[3:], xi[:3])) for xi in screws.T]
    nominal = rtb.PoERobot([rtb.PoERevolute(w, point) for w, point in axes], SE3(np.array(asked["home"])))
    library = SerialRobotKineCal(nominal)
    # The toolbox's list of links ends with the tool, which has no joint value, and its screws are of another form.
    library.joint_screw_axis, library.N_JOINTS = list(screws.T), screws.shape[1]
    library.zero_conf_EE_pose = SE3(np.array(asked["home"]))
    library.set_observations(list(np.array(asked["theta"])), list(np.array(asked["positions"])))
    found, home = library.get_calibration(library.solve())
    twists = [Twist3(xi) for xi in found]

    def predict(theta: np.ndarray) -> np.ndarray:
        places = []
        for each in theta:
            g = np.eye(4)
            for twist, x in zip(twists, each, strict=True):
                g = g @ twist.exp(x).A
            places.append((g @ home.A)[:3, 3])
        return np.array(places)

    return predict


METHODS = ("TSAI", "PARK", "HORAUD", "ANDREFF", "DANIILIDIS")
FOCAL, CENTRE, PIXELS = 600.0, (320.0, 240.0), 0.5


def hand_eye(asked: Asked) -> dict[str, Any]:
    import cv2

    rng, g = np.random.default_rng(asked["seed"]), np.array(asked["g"])
    lens = np.array([[FOCAL, 0, CENTRE[0]], [0, FOCAL, CENTRE[1]], [0, 0, 1]])
    corners = np.array([[-1, 1, 0], [1, 1, 0], [1, -1, 0], [-1, -1, 0]]) * asked["side"] / 2
    flags = cv2.SOLVEPNP_ITERATIVE if asked["seed"] % 2 else cv2.SOLVEPNP_IPPE_SQUARE
    seen = []
    for tag in np.array(asked["tags"]):
        x = corners @ tag[:3, :3].T + tag[:3, 3]
        image = FOCAL * x[:, :2] / x[:, 2:] + CENTRE + rng.normal(scale=PIXELS, size=(4, 2))
        seen.append(np.concatenate(cv2.solvePnP(corners, image, lens, None, flags=flags)[1:]).ravel())
    rvec, tvec = np.split(np.array(seen), 2, axis=1)
    found: dict[str, Any] = {}
    for name in METHODS:
        pose, method = np.eye(4), getattr(cv2, f"CALIB_HAND_EYE_{name}")
        try:
            R, t = cv2.calibrateHandEye(list(g[:, :3, :3]), list(g[:, :3, 3]), list(rvec), list(tvec), method=method)
        except cv2.error:
            continue
        pose[:3, :3], pose[:3, 3] = R, t.ravel()
        if np.isfinite(pose).all():
            found[name] = pose.tolist()
    return {"rvec": rvec.tolist(), "tvec": tvec.tolist(), "found": found}


FITS = {"twistarm": twistarm, "robotkinecal": robotkinecal}


def answer(asked: Asked) -> dict[str, Any]:
    if asked["do"] == "hand_eye":
        return hand_eye(asked)
    begin = process_time_ns()
    predict = FITS[sys.argv[1]](asked)
    took = process_time_ns() - begin
    return {"predicted": np.asarray(predict(np.array(asked["asked"]))).tolist(), "ns": took}


if __name__ == "__main__":
    serve(answer)
