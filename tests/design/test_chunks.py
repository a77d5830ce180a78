"""Sweeps in chunks: the same bits on any executor, resumed after any end, and executors that die named in one line."""

import multiprocessing
import os
import signal
from concurrent.futures import Executor, Future, ProcessPoolExecutor

import numpy as np
import pytest

from twistarm import InputError, reach_map
from twistarm.design import Sweep

COUNT, SIZE = 50, 7


def squares(scale, first, end):
    """Of each item."""
    return {"squares": scale * np.arange(first, end) ** 2}


class Backwards(Executor):
    """Runs the last call first, and dies after some of them."""

    def __init__(self, most=1000):
        self.most, self.calls = most, []

    def submit(self, work, *arguments):
        future = Future()
        self.calls.append((future, work, arguments))
        if len(self.calls) == -(-COUNT // SIZE):
            for done, (each, function, given) in enumerate(reversed(self.calls)):
                if done < self.most:
                    each.set_result(function(*given))
                else:
                    each.set_exception(RuntimeError("a node\nis gone"))
        return future


def run(work=squares, **how):
    found = np.full(COUNT, -1)
    for first, arrays in Sweep(work, 3, COUNT, SIZE, "squares of 3").run(**how):
        found[first : first + SIZE] = arrays["squares"]
    return found


EXPECTED = 3 * np.arange(COUNT) ** 2


@pytest.mark.parametrize("how", [{}, {"workers": 3}, {"executor": Backwards()}])
def test_every_item_once(how):
    told = []
    assert np.array_equal(run(**how, progress=told.append), EXPECTED)
    assert told == sorted(told)
    assert told[-1] == 1.0


@pytest.fixture(scope="module")
def processes():
    with ProcessPoolExecutor(2, multiprocessing.get_context("spawn")) as pool:
        yield pool


def test_processes_make_the_bits_of_threads(rover, processes):
    one, other = (
        reach_map(rover, 0.2, 26, method="fk", samples=50_000, **how)
        for how in ({"workers": 1}, {"executor": processes})
    )
    for name in ("counts", "manipulability", "margin"):
        assert getattr(one, name).tobytes() == getattr(other, name).tobytes()
    assert one.counts.any()


def stop_at(share):
    def progress(done):
        if done >= share:
            raise KeyboardInterrupt

    return progress


def test_ctrl_c_keeps_what_is_done(tmp_path):
    with pytest.raises(KeyboardInterrupt):
        run(folder=tmp_path / "new", progress=stop_at(0.5))
    kept = {file.name for file in (tmp_path / "new").iterdir()}
    assert 0 < len(kept) < 8

    def only_the_rest(scale, first, end):
        assert not any(name.endswith(f"-{first:012d}.npz") for name in kept)
        return squares(scale, first, end)

    only_the_rest.__qualname__ = squares.__qualname__
    assert np.array_equal(run(only_the_rest, folder=tmp_path / "new"), EXPECTED)


def test_damaged_files_are_computed_again_and_those_of_other_sweeps_left(tmp_path):
    run(folder=tmp_path)
    first, second, third, *_ = sorted(tmp_path.iterdir())
    first.write_bytes(first.read_bytes()[:40])
    second.write_bytes(b"")
    third.unlink()
    assert np.array_equal(run(folder=tmp_path), EXPECTED)
    other = Sweep(squares, 5, COUNT, SIZE, "squares of 5").run(folder=tmp_path)
    assert np.array_equal(dict(other)[0]["squares"], 5 * np.arange(SIZE) ** 2)


def test_an_executor_that_dies_tells_what_is_done(tmp_path):
    with pytest.raises(InputError, match=r"a node.*gone.*5 of 8.*chunks") as said:
        run(executor=Backwards(most=5), folder=tmp_path)
    assert str(tmp_path) in str(said.value)
    assert "\n" not in str(said.value)
    assert len(list(tmp_path.iterdir())) == 5
    assert np.array_equal(run(folder=tmp_path), EXPECTED)


@pytest.mark.parametrize(
    "how", [{"workers": 0}, {"workers": 2.5}, {"executor": 4}, {"progress": "bar"}, {"folder": "/dev/null/x"}]
)
def test_unusable_arguments(how):
    with pytest.raises(InputError):
        run(**how)


@pytest.mark.slow
def test_dask_with_a_worker_killed_makes_the_same_bits(rover, tmp_path):
    distributed = pytest.importorskip("distributed", reason="dask is not installed: pip install 'twistarm[sweep]'")
    how = {"voxel": 0.1, "method": "fk", "samples": 3_000_000}
    expected = reach_map(rover, **how)
    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        pids = list(client.run(os.getpid).values())
        killed = []

        def kill_one(done):
            if done > 0.3 and not killed:
                killed.append(pids[0])
                os.kill(pids[0], signal.SIGKILL)

        found = reach_map(rover, **how, executor=client.get_executor(), progress=kill_one)
    assert killed
    for name in ("counts", "manipulability", "margin"):
        assert getattr(found, name).tobytes() == getattr(expected, name).tobytes()
