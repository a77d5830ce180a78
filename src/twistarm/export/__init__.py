"""Export: an arm as a C++ header or a MATLAB function, its limits as joint_limits.yaml."""
