"""Mutants of real descriptions, thrown at `load_arm`: seeded, bounded, judged by an independent reading."""
