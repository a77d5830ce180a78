"""The view under attack: an honest page loads and is answered while strangers, and members, do their worst."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager

import pytest

from hostile.network import MEMBERS, SILENT, STRANGERS
from hostile.served import Result, Trouble, quiet, served

pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="processes are weighed by /proc")

SECONDS = 3.0


@contextmanager
def full_pipe() -> Iterator[int]:
    """What a program may have for stderr: a pipe that nobody reads."""
    end, begin = os.pipe()
    os.set_blocking(begin, False)
    try:
        while True:
            os.write(begin, b"x" * 4096)
    except BlockingIOError:
        os.set_blocking(begin, True)
        yield begin
    finally:
        os.close(end)
        os.close(begin)


def test_idle_strangers_and_a_terminal_that_takes_nothing_do_not_stop_the_page() -> None:
    with full_pipe() as errors, served(descriptors=256, errors=errors, warm=False) as view:
        trouble = Trouble(view)
        for name in ("idle", "requests_of_thirty"):
            result = trouble.attack(name, 1.5)
            assert (result.failures, result.log) == ([], 0)
            assert result.loads >= 2
            assert result.median < 0.1
            assert result.descriptors < 200


@pytest.mark.slow
def test_the_honest_page_goes_on_whatever_is_done() -> None:
    """Where the machine was busy with something else, an attack has a second try."""
    results: list[Result] = []
    faults: list[str] = []
    for attacks, descriptors in ((STRANGERS, 1024), (MEMBERS, 256)):
        with ExitStack() as stack:
            trouble = Trouble(stack.enter_context(served("0.0.0.0", descriptors)))
            resting = trouble.victim.descriptors()
            for name in attacks:
                for _ in range(2):
                    result = trouble.attack(name, SECONDS)
                    if not (fault := result.fault(name in SILENT)):
                        break
                results.append(result)
                faults += [f"{name}: {fault}"] if fault else []
            if quiet(trouble.victim, resting + 2) > 30:
                faults.append(f"{trouble.victim.descriptors() - resting} descriptors kept")
            print(trouble.victim.log())
    print(f"\nnetwork: {len(results)} attacks, {len(faults)} faults", *results, sep="\n")
    assert faults == []
