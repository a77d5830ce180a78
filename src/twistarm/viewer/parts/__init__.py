"""The parts of the view. Each answers requests of the pages and publishes changes."""
