# ## 3. Do the engines agree?
assert agreement.ok

# ## 5. Can it get there?
assert np.allclose(reached[:3, 3], g_so[:3, 3], atol=1e-4)
assert arm.limits.contains(theta)
assert not beyond.converged

# ## 6. How does it get there?
assert missed < 2e-4
assert np.all(motion.peak(1) <= velocity * (1 + 1e-6))
assert np.all(motion.peak(2) <= acceleration * (1 + 1e-6))
assert np.all(motion(t) >= arm.limits.lower - 1e-9)
assert np.all(motion(t) <= arm.limits.upper + 1e-9)
assert np.allclose(motion(motion.duration), arm.ready)
assert off < 2e-4
