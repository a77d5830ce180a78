"""`python -m benchmarks`: inverse kinematics, forward kinematics and Jacobians beside the peers."""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import time
from dataclasses import asdict
from pathlib import Path

from rich.console import Console

from .conductor import DEFAULT_FOLDER, NotInstalled, python_of
from .measure import Plan, Results, measure
from .peers import PEERS
from .problems import ARMS, SEED
from .report import machine, report

HERE = ("twistarm", "pinocchio")  # The solvers that need no environment of their own: those of a quick run.
PIPED_WIDTH = 120  # Columns of the tables where no terminal says how wide it is.


def main(arguments: list[str] | None = None) -> None:
    asked = _parser().parse_args(arguments)
    targets = asked.targets or (10 if asked.quick else 1000)
    batch, calls = (200, 200) if asked.quick else (10_000, 2000)
    plan = Plan(targets, unreachable=max(targets // 10, 3), batch=batch, calls=calls, seed=asked.seed)
    console = Console() if sys.stdout.isatty() else Console(width=PIPED_WIDTH)
    begin = time.perf_counter()

    def say(text: str) -> None:
        console.print(f"[{time.perf_counter() - begin:6.1f} s] {text}", highlight=False, markup=False)

    say(f"fresh problems from --seed {plan.seed}")
    results, about, pythons = Results(), machine(), dict[str, Path]()
    for peer in asked.peers or (HERE if asked.quick else PEERS):
        try:
            pythons[peer] = python_of(peer, asked.environments, say)
        except NotInstalled as reason:  # noqa: PERF203
            results.absent[peer] = str(reason)
            say(f"{peer} cannot be installed: {reason}")
    with tempfile.TemporaryDirectory() as folder:
        for arm in asked.arms:
            measure(arm, pythons, plan, Path(folder), results, say)
    report(console, results, plan, about)
    if asked.json:
        everything = json.dumps({"machine": about, "seed": SEED, "plan": asdict(plan), **asdict(results)})
        without_nan = json.loads(everything, parse_constant=lambda _: None)
        asked.json.write_text(json.dumps(without_nan, indent=1, allow_nan=False) + "\n")
        say(f"{asked.json} written")


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("--quick", action="store_true", help=f"a smoke run: few targets, {' and '.join(HERE)}")
    parser.add_argument("--arms", nargs="+", choices=tuple(ARMS), default=("panda", "ur5", "jaco", "so101"),
                        metavar="ARM", help=", ".join(ARMS))  # fmt: skip
    parser.add_argument("--peers", nargs="+", choices=PEERS, metavar="PEER", help=", ".join(PEERS))
    parser.add_argument("--targets", type=_count, metavar="N", help="of each kind for each arm; 1000")
    parser.add_argument("--seed", type=int, default=int(time.time()), help="of the fresh problems; from the clock")
    parser.add_argument("--environments", type=Path, default=DEFAULT_FOLDER, metavar="FOLDER",
                        help="where the peers are installed; benchmarks/.environments")  # fmt: skip
    parser.add_argument("--json", type=Path, metavar="FILE", help="write all figures")
    return parser


def _count(text: str) -> int:
    number = int(text)
    if number < 1:
        raise argparse.ArgumentTypeError(f"must be at least 1; got {text}")
    return number


if __name__ == "__main__":
    main()
