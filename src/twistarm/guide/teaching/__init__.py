"""The calls of a lesson: its arm, what it says, its figures, scenes and sliders."""
