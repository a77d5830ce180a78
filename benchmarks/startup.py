"""The cost of starting: fresh interpreters in turn, medians, and ratios to importing Pinocchio.

Allowed: `import twistarm` 0.1 s beyond NumPy; with `load_arm("rover_arm")` 1.5 × `import pinocchio` + 0.5 s.
"""

import statistics
import subprocess
import sys
import time

ROUNDS = 9
PROGRAMS = {
    "python": "",
    "numpy": "import numpy",
    "pinocchio": "import pinocchio",
    "twistarm": "import twistarm",
    "twistarm, rover_arm loaded": "import twistarm; twistarm.load_arm('rover_arm')",
}


def seconds(program: str) -> float:
    start = time.perf_counter()
    subprocess.run([sys.executable, "-c", program], check=True)
    return time.perf_counter() - start


def main() -> None:
    times: dict[str, list[float]] = {name: [] for name in PROGRAMS}
    for _ in range(ROUNDS):
        for name, program in PROGRAMS.items():
            times[name].append(seconds(program))
    medians = {name: statistics.median(values) for name, values in times.items()}
    print(f"start-up, median of {ROUNDS} interleaved rounds of fresh interpreters")
    for name, median in medians.items():
        print(f"  {name:28s} {median:6.3f} s   {median / medians['pinocchio']:5.2f} × import pinocchio")
    beyond = medians["twistarm"] - medians["numpy"]
    allowed = 1.5 * medians["pinocchio"] + 0.5
    print(f"  import twistarm beyond NumPy: {beyond:.3f} s (allowed 0.100 s)")
    print(f"  with load_arm('rover_arm'): {medians['twistarm, rover_arm loaded']:.3f} s (allowed {allowed:.3f} s)")


if __name__ == "__main__":
    main()
