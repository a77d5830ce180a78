"""What judges the core from outside: SciPy's optimisers, the conditions of optimality, the servo's law in NumPy."""
