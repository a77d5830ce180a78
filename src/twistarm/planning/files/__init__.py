"""Motions in files: CSV for people and plots, JSON and YAML as ROS's JointTrajectory, C headers for firmware."""
