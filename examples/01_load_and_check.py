"""Load an arm by path or name, look at it as screws, and prove that view against the other engines."""

import sys

import numpy as np

from twistarm import crosscheck, load_arm, screws

arm = load_arm(sys.argv[1] if len(sys.argv) > 1 else "rover_arm")
print(f"{arm.name}: {arm.n} degrees of freedom from {arm.base} to {arm.tip}")
for finding in arm.findings:
    print(f"  {finding}")

print("the joints as screws, in the base frame at theta = 0:")
for name, unit, xi in zip(arm.joint_names, arm.units, (arm.screws @ arm.coupling.A).T, strict=True):
    screw = screws.to_screw(xi)
    kind = "turns about" if np.isfinite(screw.pitch) else "slides along"
    print(f"  {name} [{unit}] {kind} {np.round(screw.axis, 3)} through {np.round(screw.point, 3)} m")

# The worst difference between product of exponentials, Pinocchio, yourdfpy and finite differences.
result = crosscheck(arm, samples=200).require()
print(
    f"all engines agree: {result.worst('pinocchio'):.1e} from Pinocchio, {result.worst('yourdfpy'):.1e} from yourdfpy"
)
assert result.worst("pinocchio") < 1e-12
