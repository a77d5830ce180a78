"""The servo's law in NumPy, which judges the compiled one."""
