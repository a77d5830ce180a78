"""Lessons made into a site: read, run in separate processes, and written as pages."""
