"""All configurations that meet a target: families with a closed form, elimination, verification."""
