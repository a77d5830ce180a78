"""The protocol between page and process: messages, changes, and work in threads."""
