"""MuJoCo's MJCF to URDF, which the rest of the package reads."""
