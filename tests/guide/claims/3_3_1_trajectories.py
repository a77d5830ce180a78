# ## The straight path and its time law
assert np.allclose(cubic.coeffs, [-2.0, 3.0, 0.0, 0.0])

# ## Two more conditions: the quintic
for derivative in (1, 2):
    assert np.allclose(quintic.deriv(derivative)([0.0, 1.0]), 0.0)
assert np.allclose(peaks["cubic"], [3 / 2, 6, 12])
assert np.allclose(peaks["quintic"], [15 / 8, 10 / np.sqrt(3), 60], atol=1e-4)

# ## Limits: how long must it take?
nothing_else = arm.actuators is None and not np.isfinite(given.jerk).any()
assert motion.duration >= shortest - 1e-9
assert np.isclose(motion.duration, shortest) or not nothing_else
assert np.all(motion.peak(1) <= velocity * (1 + 1e-9))
assert np.all(motion.peak(2) <= acceleration * (1 + 1e-9))

# ## Via points
assert np.allclose(through(through.times[1]), via, atol=1e-8)
assert through.duration <= stopping.duration + 1e-9
meeting = through.times[1]
just_before, just_after = through(meeting - 1e-7, 2), through(meeting + 1e-7, 2)
assert np.allclose(just_before, just_after, atol=1e-4 * acceleration.max())

# ## Straight in what?
for way in (by_joints, by_screw, by_line):
    assert np.allclose(way[0], g0)
    assert np.allclose(way[-1], g1)
# The screw is the same motion, whoever looks: from the base (above) or from the tool.
from_the_tool = g0 @ screws.exp(screws.log(screws.inverse(g0) @ g1), share)
assert np.allclose(from_the_tool, by_screw)
assert off_the_chord(by_line[:, :3, 3]) < 1e-9

# ## Let the planner do it
assert off_the_chord(tool) < 1e-4
assert np.isclose(length_of(tool), length, atol=1e-3 * pusher.reach)

# ## What goes wrong in practice
for dt in (0.01, 0.05, 0.2):
    grid = np.append(np.arange(0, motion.duration, dt), motion.duration)
    fine = np.linspace(0, motion.duration, 4001)
    chords = np.stack([np.interp(fine, grid, column) for column in motion(grid).T], axis=-1)
    off = np.abs(chords - motion(fine)).max(axis=0)
    assert np.all(off <= motion.peak(2) * dt**2 / 8 + 1e-9)
