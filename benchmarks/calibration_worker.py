"""One library that calibrates arms, in its own environment. `python -m benchmarks.calibration_worker PEER`.

It reads one JSON object per line and answers with one line each, as `worker.py` does:

  {"do": "fit", "arm", "screws", "home", "theta", "positions", "asked"}          {"predicted", "ns"} or {"error"}

`screws` and `home` are the nominal arm with the tool's point as its tip, and `positions` (K, 3) [m] are seen from its
base: base and tool come from a fit of these rows. `predicted` are the positions at `asked` (N, n). `ns` is processor
time.
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


FITS = {"twistarm": twistarm, "robotkinecal": robotkinecal}


def answer(asked: Asked) -> dict[str, Any]:
    begin = process_time_ns()
    predict = FITS[sys.argv[1]](asked)
    took = process_time_ns() - begin
    return {"predicted": np.asarray(predict(np.array(asked["asked"]))).tolist(), "ns": took}


if __name__ == "__main__":
    serve(answer)
