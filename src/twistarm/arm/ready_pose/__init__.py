"""A computed configuration to start from, in round numbers."""
