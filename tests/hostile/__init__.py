"""The view's server as a stranger reaches it."""
