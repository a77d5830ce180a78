"""All configurations that reach a target: families with a closed form, elimination, verification."""
