"""Follow a trajectory on a robot: start, pause, resume and stop along its path."""
