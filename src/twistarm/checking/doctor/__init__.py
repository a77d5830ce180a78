"""The arm doctor: findings about a description, each with its remedy, and a copy with the safe repairs made."""

from .diagnosis import Diagnosis, diagnose, examine, examine_arm

__all__ = ["Diagnosis", "diagnose", "examine", "examine_arm"]
