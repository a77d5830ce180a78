"""The arm and its kinematics: compiled, by Pinocchio, by the product of exponentials; baked arms; arms from screws."""
