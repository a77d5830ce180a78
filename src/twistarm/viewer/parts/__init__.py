"""The parts of the view: each answers requests of the pages and tells them what has changed."""
