"""`solve_ik_batch`: the verdicts of `solve_ik`, any number of targets of any kinds, progress, and an end when asked."""

import os
import pickle
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from catalogue import load
from ik_targets import KINDS, judged, require_core, target_from
from twistarm.ik import Pose, Position, StopReason, solve_ik, solve_ik_batch


def problems(arm, count, seed=0):
    """Poses (count, 4, 4) that the arm reaches, and as many starts."""
    rng = np.random.default_rng(seed)
    return arm.by_pinocchio(arm.random_theta(rng, count))[0], arm.random_theta(rng, count)


@pytest.fixture(scope="module")
def arm():
    arm = load("rover_arm_6dof")
    require_core(arm)
    return arm


def test_the_verdicts_are_those_of_one_by_one(arm):
    """Of all kinds together, one in four out of reach."""
    rng = np.random.default_rng(1)
    g, theta0 = problems(arm, 80)
    g[::5, :3, 3] *= 1.7
    targets, fractions = [target_from(KINDS[i % 4], pose, rng) for i, pose in enumerate(g)], []
    batch = solve_ik_batch(arm, targets, theta0, progress=fractions.append)
    for ours, target, start in zip(batch, targets, theta0, strict=True):
        alone = solve_ik(arm, target, start)
        assert ours.target is target
        assert ours.stop is alone.stop
        assert ours.position_error <= max(1e-6, alone.position_error + 1e-6)
        assert judged(arm, target, ours) == ours.converged
    assert fractions == sorted(fractions)
    assert fractions[-1] == 1.0


def test_an_answer_depends_on_its_own_target_alone(arm):
    g, theta0 = problems(arm, 1500)
    together = solve_ik_batch(arm, g, theta0).theta
    np.testing.assert_array_equal(solve_ik_batch(arm, g, theta0, threads=2).theta, together)
    order = np.random.default_rng(2).permutation(len(g))
    np.testing.assert_array_equal(solve_ik_batch(arm, g[order], theta0[order]).theta, together[order])
    shared = solve_ik_batch(arm, g[:20], np.tile(arm.ready, (20, 1))).theta
    for same in (solve_ik_batch(arm, g[:20]), solve_ik_batch(arm, g[:20], arm.ready)):
        np.testing.assert_array_equal(same.theta, shared)


def test_arrays_in_any_order_and_at_odd_addresses(arm):
    g, theta0 = problems(arm, 10)
    expected = solve_ik_batch(arm, g, theta0).theta
    for same in (np.asfortranarray(g), tuple(map(Pose, g))):
        np.testing.assert_allclose(solve_ik_batch(arm, same, np.asfortranarray(theta0)).theta, expected, atol=1e-9)
    odd = np.frombuffer(bytearray(1 + theta0.nbytes), np.float64, theta0.size, offset=1).reshape(theta0.shape)
    odd[:] = theta0
    np.testing.assert_array_equal(solve_ik_batch(arm, g, odd, posture=odd).theta,
                                  solve_ik_batch(arm, g, theta0, posture=theta0).theta)  # fmt: skip
    np.testing.assert_array_equal(solve_ik(arm, g[0], odd[0]).theta, solve_ik(arm, g[0], theta0[0]).theta)
    np.testing.assert_array_equal(arm.fk(odd), arm.fk(theta0))


def test_what_was_asked_is_kept(arm):
    g, theta0 = problems(arm, 3)
    mine = g.copy()
    batch = solve_ik_batch(arm, mine, theta0)
    mine[:] = np.eye(4)
    np.testing.assert_array_equal(batch[1].target.g, g[1])
    assert not batch.theta.flags.writeable
    copy = pickle.loads(pickle.dumps(batch))
    np.testing.assert_array_equal(copy.theta, batch.theta)
    assert batch[-1].explain() == batch[2].explain()
    with pytest.raises(IndexError):
        batch[3]
    assert solve_ik_batch(arm, g[:0]).theta.shape == (0, arm.n)


def test_a_posture_holds_for_every_target():
    arm = load("panda")
    g, theta0 = problems(arm, 30)
    batch = solve_ik_batch(arm, g, theta0, posture="middle")
    plain = solve_ik_batch(arm, g, theta0)
    away = [np.linalg.norm(answer.theta - arm.limits.middle(), axis=1) for answer in (batch, plain)]
    assert batch.converged.all()
    assert (away[0] <= away[1] + 1e-9).all()
    own = solve_ik_batch(arm, g, theta0, posture="theta0").theta
    single = [solve_ik_batch(arm, g[i : i + 1], theta0[i], posture=theta0[i]).theta[0] for i in range(3)]
    np.testing.assert_array_equal(own[:3], single)


def test_the_time_is_up_before_all_are_begun(arm):
    g, theta0 = problems(arm, 20000)
    batch = solve_ik_batch(arm, g, theta0, max_time=0.002)
    late = batch.stop == StopReason.TIMED_OUT
    assert late.any()
    assert not batch.converged.all()
    assert arm.limits.contains(batch.theta[late]).all()
    assert "time was up" in batch[int(np.argmax(late))].explain()


def test_an_error_in_progress_ends_the_batch(arm):
    g, theta0 = problems(arm, 1000)

    def broken(fraction):
        raise RuntimeError("the bar broke")

    with pytest.raises(RuntimeError, match="the bar broke"):
        solve_ik_batch(arm, np.tile(g, (100, 1, 1)), np.tile(theta0, (100, 1)), progress=broken)


LONG = """
import sys, numpy as np, twistarm
arm = twistarm.load_arm("panda")
g = arm.fk(arm.random_theta(np.random.default_rng(0), 1000))
far, many = g[0] + np.diag([0, 0, 5.0], 1), np.tile(g, (1000, 1, 1))
print("begun", flush=True)
try:
    while sys.argv[1] == "one":  # a search that proves the pose out of reach ends by itself
        twistarm.solve_ik(arm, far, restarts=10**6)
    if sys.argv[1] == "endless":
        twistarm.solve_ik_batch(arm, [far] * 8, restarts=10**6)
    while True:  # a fast machine may be done with one before the signal comes
        twistarm.solve_ik_batch(arm, many, threads=2)
except KeyboardInterrupt:
    print("interrupted", flush=True)
"""


def seconds_until_interrupted(what):
    command = [sys.executable, "-c", LONG, what]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as running:
        assert running.stdout is not None
        assert running.stdout.readline() == "begun\n"
        time.sleep(1.0)
        running.send_signal(signal.SIGINT)
        begun = time.perf_counter()
        assert running.stdout.readline() == "interrupted\n"
        return time.perf_counter() - begun


@pytest.mark.alone
@pytest.mark.parametrize("what", ["one", "endless", "many"])
def test_ctrl_c_ends_a_million_searches(arm, what):
    assert any(seconds_until_interrupted(what) < 0.2 for _ in range(3))


def test_two_threads_on_one_arm(arm):
    g, theta0 = problems(arm, 400)

    def work(_):
        singles = [solve_ik(arm, *pair).theta for pair in zip(g, theta0, strict=True)]
        return solve_ik_batch(arm, g, theta0).theta, singles

    expected = work(0)
    with ThreadPoolExecutor(2) as pool:
        for answers in pool.map(work, range(2)):
            np.testing.assert_array_equal(answers, expected)


def test_after_a_fork(arm):
    g, theta0 = problems(arm, 400)
    expected = solve_ik_batch(arm, g, theta0, threads=2).theta
    child = os.fork()
    if child == 0:
        same = False
        try:
            same = bool((solve_ik_batch(arm, g, theta0, threads=2).theta == expected).all())
        finally:
            os._exit(0 if same else 1)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0


def test_every_field_is_that_of_the_answer_alone():
    """Blocked targets and reachable ones, of two kinds, starts outside the limits, few searches, another seed."""
    small, stops = load("so101"), set()
    g, _ = problems(small, 6, seed=7)
    g[1::2, :3, :3] = g[1::2, :3, :3] @ np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
    targets = [Pose(pose) if i % 3 else Position(pose[:3, 3]) for i, pose in enumerate(g)]
    starts = small.random_theta(np.random.default_rng(6), 6) + np.array([4.0, 0, 0, 0, 0])
    how = {"restarts": 3, "rng": 5, "posture": "theta0"}
    batch = solve_ik_batch(small, targets, starts, **how)
    for i, (target, start, ours) in enumerate(zip(targets, starts, batch, strict=True)):
        alone, single = solve_ik_batch(small, [target], start, **how)[0], solve_ik(small, target, start, **how)
        stops.add(ours.stop)
        for name in ("iterations", "restarts", "position_error", "orientation_error"):
            assert getattr(ours, name) == getattr(alone, name) == getattr(batch, name)[i], name
        assert (ours.stop, ours.notes, ours.method) == (single.stop, single.notes, single.method)
        assert ours.position_error == pytest.approx(single.position_error, abs=2e-6)
        assert ours.orientation_error == pytest.approx(single.orientation_error, abs=2e-5)
        assert ours.restarts <= 3
        assert ours.notes, "every start lies outside"
        assert (ours.unlimited is None) == (single.unlimited is None)
        assert ours.unlimited is None or not small.limits.contains(ours.unlimited)
    assert StopReason.CONVERGED in stops
    assert len(stops) > 1
