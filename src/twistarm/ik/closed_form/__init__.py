"""All configurations that meet a target: families of arms with a closed form, elimination, and the verification."""
