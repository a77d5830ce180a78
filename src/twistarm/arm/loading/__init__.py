"""From a description and its companions to a proven arm; arms built in Python; a first arm.toml."""
