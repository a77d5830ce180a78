"""Paths of the tool: curves of poses, and the joint paths that follow them."""
