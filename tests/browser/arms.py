"""Arms that the page is tried with: one in the quick tests, in the long ones the others too."""

import pytest

ARMS = ("rover_arm", *(pytest.param(name, marks=pytest.mark.slow) for name in ("rover_arm_6dof", "panda")))
