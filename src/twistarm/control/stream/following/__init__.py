"""A trajectory followed on a robot: begun where the arm is, paused, resumed and stopped along its path."""
