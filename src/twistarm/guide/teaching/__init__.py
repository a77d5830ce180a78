"""Helpers that the lessons call."""
