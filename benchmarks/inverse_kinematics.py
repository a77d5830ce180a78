"""`solve_ik` beside Pinocchio's example loop with random restarts: the same targets, in turn, every answer re-checked.

Targets are built reachable: poses of random configurations inside the limits. Both start from the middle of the
limits and must meet 1e-6 m and 1e-6 rad inside the limits, judged by Pinocchio. Ratios count; absolute times depend
on the machine.
"""

import sys
import time

import numpy as np
import pinocchio as pin

from twistarm import Arm, Pose, load_arm, solve_ik

ARMS = ("panda", "ur5", "kinova", "rover_arm_6dof")
TARGETS = int(sys.argv[1]) if len(sys.argv) > 1 else 50
TOL = 1e-6
RESTARTS, ITERATIONS, STEP, DAMPING = 100, 200, 0.5, 1e-12


def pinocchio_loop(arm: Arm, goal: np.ndarray, start: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """The loop of Pinocchio's inverse kinematics example (log6, damped pseudo-inverse), clipped, with restarts."""
    target = pin.SE3(goal)
    theta = start
    for _ in range(RESTARTS):
        for _ in range(ITERATIONS):
            g, J = arm.fk_and_body_jacobian(theta)
            error = pin.log6(pin.SE3(g).actInv(target)).vector
            if np.abs(error).max() < TOL / 10:
                return theta
            step = J.T @ np.linalg.solve(J @ J.T + DAMPING * np.eye(6), error)
            theta = np.clip(theta + STEP * step, arm.limits.lower, arm.limits.upper)
        theta = arm.random_theta(rng)
    return theta


def strict(arm: Arm, theta: np.ndarray, goal: np.ndarray) -> bool:
    error = pin.log6(pin.SE3(arm.fk(theta)).actInv(pin.SE3(goal))).vector
    met = max(np.linalg.norm(error[:3]), np.linalg.norm(error[3:])) <= 2 * TOL
    return bool(met and arm.limits.contains(theta, 1e-7))


def main() -> None:
    print(f"{TARGETS} cold poses per arm, interleaved; strict {TOL:g} m and rad, inside the limits")
    print(f"{'arm':16s} {'twistarm':>24s} {'Pinocchio example loop':>26s} {'ratio of medians':>18s}")
    for name in ARMS:
        arm = load_arm(name)
        rng = np.random.default_rng(20260701)
        start = np.clip(np.zeros(arm.n), *arm.sampling_bounds)
        times: dict[str, list[float]] = {"ours": [], "loop": []}
        met = {"ours": 0, "loop": 0}
        for theta in arm.random_theta(rng, TARGETS):
            goal = arm.fk(theta)
            for who in times:
                begin = time.perf_counter()
                if who == "ours":
                    answer = solve_ik(arm, Pose(goal), start).theta
                else:
                    answer = pinocchio_loop(arm, goal, start, rng)
                times[who].append(1e3 * (time.perf_counter() - begin))
                met[who] += strict(arm, answer, goal)
        median = {who: float(np.median(values)) for who, values in times.items()}
        cells = [f"{100 * met[who] / TARGETS:5.1f} %  {median[who]:8.2f} ms" for who in times]
        print(f"{name:16s} {cells[0]:>24s} {cells[1]:>26s} {median['loop'] / median['ours']:16.1f} ×")


if __name__ == "__main__":
    main()
