"""Companion files of a description: arm.toml, SRDF, joint_limits.yaml."""
