"""Export: an arm as a C++ header, as a function of MATLAB, its limits as a joint_limits.yaml."""
