"""The scene: what is drawn of an arm, as Meshcat draws it."""
