"""What a type checker says of programs: it accepts those of the README and the examples, and refuses nonsense."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
EXAMPLES = sorted(file for file in (ROOT / "examples").rglob("*.py") if "ros2" not in file.relative_to(ROOT).parts)

ACCEPTED = """
import numpy as np
from twistarm import Approach, Arm, JogCommand, JointLimits, Pose, PoseCommand, Position, ServoState
from twistarm import TolerancedPose, Trajectory
from twistarm import Dwell, JointMove, LineMove, Segment, TwistCommand, load_arm, plan, plan_joint, servo_step
from twistarm import solve_ik, solve_ik_batch

arm: Arm = load_arm("rover_arm")
down = Approach(p=[0.5, 0, 0.3], direction=[0, 0, 1])
both = Approach((0.5, 0, 0.3), np.array([0, 0, -1]), tool_axis=[1, 0, 0])
rows = [[1.0, 0, 0, 0.5], [0.0, 1, 0, 0], [0.0, 0, 1, 0.3], [0, 0, 0, 1.0]]
one = solve_ik(arm, rows, [0, 0, 0, 0, 0], rng=np.random.default_rng(0)).theta
many = solve_ik_batch(arm, [down, both, Position([0.5, 0, 0.3]), Pose(rows),
    TolerancedPose(rows, [0.0] * 6), rows, np.eye(4)])
stack = solve_ik_batch(arm, arm.fk(arm.random_theta(0, 10))).theta
state, output = servo_step(arm, ServoState.at(arm, arm.ready), [0.1, 0, 0, 0, 0, 0], dt=0.01)
for command in (TwistCommand([0, 0, 0, 0, 0, 1]), JogCommand([0.1] * 5), PoseCommand(rows), None):
    state, output = servo_step(arm, state, command, dt=0.01)
tour: list[Segment] = [LineMove.by([0, 0, 0.05]), Dwell(0.5), JointMove("ready")]
plan(arm, tour)
plan(arm, [LineMove.by([0, 0, 0.05]), Dwell(0.5)])
motion: Trajectory = plan_joint(arm, ["ready", {"elbow": 1.0}, arm.ready, [0, 0, 0, 0, 0]])
"""

REFUSED = """
from twistarm import Approach, Pose, ServoState, TwistCommand, load_arm, servo_step, solve_ik, solve_ik_batch

arm = load_arm("rover_arm")
state = ServoState.at(arm, arm.ready)
solve_ik(arm, "banana")
solve_ik("rover_arm", Pose([[1.0]]))
solve_ik(arm, None)
solve_ik_batch(arm, "banana")
solve_ik_batch(arm, ["banana"])
servo_step(arm, state, "go", dt=0.01)
servo_step(arm, arm.ready, None, dt=0.01)
Approach("p", [0, 0, 1])
TwistCommand("up")
arm.random_theta("seed")
"""


@pytest.mark.slow
def test_mypy_accepts_the_readme_and_refuses_nonsense(tmp_path: Path) -> None:
    """One run for all; without a cache mypy needs some 10 s to read NumPy and the package, hence slow."""
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text("utf-8"), flags=re.S)
    programs = {f"readme_{k}.py": text for k, text in enumerate(blocks)} | {"good.py": ACCEPTED, "bad.py": REFUSED}
    for name, text in programs.items():
        (tmp_path / name).write_text(text, "utf-8")
    files = [tmp_path / name for name in programs] + EXAMPLES
    command = [sys.executable, "-m", "mypy", "--strict", "--no-error-summary", "--hide-error-context", *map(str, files)]
    said = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=300, check=False)
    lines = [re.match(r"(.*?):(\d+): error: ", line) for line in said.stdout.splitlines()]
    found = {(Path(match[1]).name, int(match[2])) for match in lines if match}
    expected = {("bad.py", k) for k, line in enumerate(REFUSED.splitlines(), 1) if re.match(r"\S+\(", line)}
    assert found == expected, said.stdout + said.stderr
