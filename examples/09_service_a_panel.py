"""Where does the rover park to service a panel, and what does its arm do there? One motion for all that it can do."""

from dataclasses import replace
from pathlib import Path

import numpy as np
from play import play_if_asked

from twistarm import best_parking, check_panel, load_arm, load_panel

arm = load_arm("rover_arm")
panel = load_panel(Path(__file__).with_name("urc_panel.toml"))
asked = ("key U", "knob", "latch", "hinged panel", "open drawer", "tighten screw")
panel = replace(panel, tasks=tuple(each for each in panel.tasks if each.name in asked), size=None)

report = best_parking(arm, panel)
x, y, _ = report.base[:3, 3]
print(f"park at x = {x:.2f} m, y = {y:.2f} m: {len(report.done)} of {len(panel.tasks)} tasks")

# The plane of this arm cannot turn sideways, and the hinged panel would take the hand round a vertical axis.
(missed,) = (each for each in report.results if each.code != "done")
assert missed.task.name == "hinged panel"
assert missed.code == "impossible_direction"
print(f"{missed.task.name}: {missed.why}")

# What was found holds from there alone: farther away the same tasks are out of reach.
farther = panel.base_at(x - 0.5, y, 0.0)
assert not check_panel(arm, panel, farther).done

# The knob: between its labels the tool turns by a quarter of a turn about the panel's normal, in its place.
motion = report.motion(limits={"acceleration": 3.0})
assert [label for _, label in motion.labels] == [each.task.name for each in report.done]
end = next(moment for moment, label in motion.labels if label == "knob")
begin = motion.times[np.searchsorted(motion.times, end - 1e-9) - 1]
g = report.base @ arm.fk(motion(np.linspace(begin, end, 200)))
turned = g[-1, :3, :3] @ g[0, :3, :3].T
into = -panel.pose[:3, 2]
assert np.allclose(turned @ into, into, atol=1e-3)
assert np.isclose(np.trace(turned), 1.0, atol=2e-3), "90°"
assert np.ptp(g[:, :3, 3], axis=0).max() < 2e-4
print(f"all {len(report.done)} tasks in one motion of {motion.duration:.0f} s")
play_if_asked(arm, motion)
