"""The tool stays in place while a slider weighs manipulability against the distance from limits; --view shows it."""

import sys

import numpy as np

from twistarm import Approach, load_arm, solve_ik_all
from twistarm.viewer import Viewer

arm = load_arm("rover_arm")
place = np.array([0.8, 0.1, 0.7])

# The place leaves the tool's pitch free. Each pitch has up to two configurations: together the self-motion in steps.
pitches = np.radians(np.arange(-80, 81, 4))
ways = [Approach(place, direction=[np.cos(pitch), 0, -np.sin(pitch)]) for pitch in pitches]
answers = np.array([theta for way in ways for theta in solve_ik_all(arm, way)])

# Both measures are 1 at their best: Yoshikawa's, and the share of half its range that the joint nearest a limit has.
ability = np.array([float(arm.manipulability(theta).yoshikawa) for theta in answers])
ability /= ability.max()
lower, upper = arm.limits.lower, arm.limits.upper
turning = np.isfinite(upper - lower)
room = np.minimum(answers - lower, upper - answers)[:, turning] / (0.5 * (upper - lower)[turning])
room = room.min(axis=1) / room.min(axis=1).max()


def best(weight: float) -> int:
    """The answer of least cost: 0 asks for room alone, 1 for manipulability alone."""
    return int(np.argmin(-weight * ability - (1.0 - weight) * room))


chosen = [best(weight) for weight in np.linspace(0.0, 1.0, 21)]
assert room[chosen[0]] == 1.0
assert ability[chosen[-1]] == 1.0
assert (np.diff(ability[chosen]) >= 0.0).all(), "more weight never costs manipulability"
assert (np.diff(room[chosen]) <= 0.0).all()
assert len(set(chosen)) > 1
for theta in answers[chosen]:  # Pinocchio judges
    assert np.allclose(arm.by_pinocchio(theta)[0][:3, 3], place, atol=1e-9)

with Viewer(arm, open_browser="--view" in sys.argv[1:]) as viewer:
    words = viewer.text("measures", "")

    def weigh(weight: float) -> None:
        """Called with every new value of the slider."""
        i = best(weight)
        viewer.show(answers[i])
        viewer.draw.arrow("tool", place, place + 0.2 * arm.fk(answers[i])[:3, 2], (0.9, 0.5, 0.0))
        words.value = f"manipulability {ability[i]:.0%}, room {room[i]:.0%}"

    slider = viewer.slider("weight", 0.0, 1.0, weigh, value=0.5)
    viewer.draw.points("places", arm.fk(answers)[:, :3, 3] - 0.1 * arm.fk(answers)[:, :3, 2])
    weigh(slider.value)
    assert np.allclose(viewer.theta, answers[best(0.5)])
    print(f"{len(answers)} configurations hold the tool in place; weight {slider.value:g}: {words.value}")
    if "--view" in sys.argv[1:]:
        viewer.wait()
