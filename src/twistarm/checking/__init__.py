"""Proof: an arm compared with other engines, and with what it was when it was frozen."""
