"""Base and tip of an arm, chosen from its description: limbs, and what the names of links tell."""
