"""The servo on many arms: shaking under held twists, limits under a joystick, paths, ways out of singularities and off
limits, and the time of a step beside forward kinematics.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from pathlib import Path

from rich.console import Console

from . import servo_held, servo_joystick, servo_leaving, servo_path
from .machine import machine
from .servo_arms import names
from .servo_named import plot
from .servo_report import report
from .servo_time import CALLS, measured

PARTS = {"held": servo_held, "joystick": servo_joystick, "path": servo_path, "leaving": servo_leaving}

SHARES = {"held": 1.0, "joystick": 5.0, "path": 0.2, "leaving": 0.2}
"""Of --count, how often each is tried on an arm."""

PIPED_WIDTH = 120
"""Columns of the tables where no terminal says how wide it is."""


def main(arguments: list[str] | None = None) -> None:
    parser = _parser()
    asked = parser.parse_args(arguments)
    if min(asked.count, asked.rounds, asked.steps) < 1:
        parser.error("--count, --rounds and --steps must be at least 1")
    console = Console() if sys.stdout.isatty() else Console(width=PIPED_WIDTH)
    begin = time.perf_counter()

    def say(text: str) -> None:
        console.print(f"[{time.perf_counter() - begin:6.1f} s] {text}", highlight=False, markup=False)

    everything: dict[str, object] = {"machine": machine(), "count": asked.count, "seed": asked.seed}
    found: dict[str, list[dict[str, object]]] = {part: [] for part in PARTS}
    for number, name in enumerate(asked.arms, 1):
        for part, module in PARTS.items():
            found[part].append(module.figures(name, max(1, round(SHARES[part] * asked.count)), asked.seed))
        say(f"{name}: {number} of {len(asked.arms)} arms")
    everything |= {**found, **measured(asked.rounds, asked.steps)}
    report(console, everything)
    if asked.json:
        asked.json.write_text(json.dumps(everything, indent=1, allow_nan=False) + "\n")
        say(f"{asked.json} written")
    if asked.plot:
        plot(asked.plot)
        say(f"{asked.plot} written")


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.servo", description=__doc__)
    parser.add_argument("--arms", nargs="+", choices=names(), default=names(), metavar="ARM", help=", ".join(names()))
    parser.add_argument("--count", type=int, default=200, metavar="N",
                        help="held twists of an arm, with limits of acceleration and without; drives by joystick are "
                        "five times as many, lines and ways out a fifth; 200")  # fmt: skip
    parser.add_argument("--seed", type=int, default=1, help="of the cases; 1")
    parser.add_argument("--rounds", type=int, default=50, help=f"of {CALLS} steps that are timed; 50")
    parser.add_argument("--steps", type=int, default=1_000_000, help="after which memory is looked at; 1,000,000")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write all figures, and the cases that shake")
    parser.add_argument("--plot", type=Path, metavar="FILE", help="draw the joints' rates of two examples")
    return parser


if __name__ == "__main__":
    main()
