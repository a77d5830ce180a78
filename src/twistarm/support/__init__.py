"""Foundations of every room: errors, checked arguments, files, strict JSON and CSV, interrupts. Knows no robot."""
