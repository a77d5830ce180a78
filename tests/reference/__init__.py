"""What judges inverse kinematics from outside: SciPy's optimisers and the conditions of optimality."""
