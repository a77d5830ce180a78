"""Lessons made into a site: read, run, each in a process of its own, and written as pages."""
