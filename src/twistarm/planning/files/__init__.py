"""Files of motions: CSV, ROS's JointTrajectory in JSON and YAML, C headers for firmware."""
