"""What the elbow of an arm needs to carry 2 kg along a motion, and the gear ratios that a motor offers for it."""

from twistarm import load_arm, payload, plan_joint

MASS, TORQUE, SPEED, EFFICIENCY = 2.0, 0.6, 300.0, 0.7  # kg; the motor's N m and rad/s; the gear's share

arm = load_arm("rover_arm")
motion = plan_joint(arm, ["stowed", "reach", "ready"])
held = payload(arm, motion)
needs = held.needs(MASS)
assert (needs.share < 1.0).all()
assert held.mass.min() > MASS

# The least ratio brings the torque, the greatest the speed: any between them fits.
elbow = needs.names.index("elbow")
least, greatest = needs.effort[elbow] / (EFFICIENCY * TORQUE), SPEED / needs.speed[elbow]
assert least < greatest
print(f"elbow: {needs.effort[elbow]:.1f} N m, {needs.speed[elbow]:.2f} rad/s, {needs.power[elbow]:.1f} W")
print(f"ratios from {least:.0f} to {greatest:.0f}; the arm could carry {held.mass.min():.2f} kg on this way")

# From rest to rest the joints' work goes into height alone: none of it into speed, and nothing is lost to friction.
t, theta, theta_dot, theta_ddot = motion.sample(0.001)
push = arm.torques(theta, theta_dot, theta_ddot, payload=MASS) - arm.torques(theta, payload=MASS)
assert abs((push * theta_dot).sum() * 0.001) < 1e-3
