"""The protocol between page and process: messages, what has changed since the last, and work in threads."""
