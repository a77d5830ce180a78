"""The doctor: findings about a description with remedies, and a repaired copy."""

from .diagnosis import Diagnosis, diagnose, examine, examine_arm

__all__ = ["Diagnosis", "diagnose", "examine", "examine_arm"]
