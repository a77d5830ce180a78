"""twistarm: the kinematics of robot arms in the language of screws.

Conventions, everywhere: SI units and radians; `theta` (..., n) is one number per degree of freedom, base to tip; a
pose `g_ab` (..., 4, 4) is frame b seen from frame a, p_a = g_ab @ p_b; a twist is (v, w), linear part first, as in
Murray, Li & Sastry and in Pinocchio; s is the space frame (the base link), t the tool frame (the tip link).
"""

from .arm import Arm, Coupling, Proof
from .building import arm_from_screws
from .comparison import Comparison, CrossCheck, crosscheck
from .golden import Difference, compare, freeze
from .limits import JointLimits
from .loading import available_arms, load_arm

__version__ = "0.1.0"

__all__ = [
    "Arm",
    "Comparison",
    "Coupling",
    "CrossCheck",
    "Difference",
    "JointLimits",
    "Proof",
    "arm_from_screws",
    "available_arms",
    "compare",
    "crosscheck",
    "freeze",
    "load_arm",
]
