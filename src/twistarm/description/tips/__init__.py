"""Base and tip of an arm, from the tree of its joints and the names of its links."""
