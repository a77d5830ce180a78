"""The arm: its kinematics, compiled, by Pinocchio and by the product of exponentials; baked arms; arms from screws."""
