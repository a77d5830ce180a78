"""Links of a stream: UDP, serial lines and inboxes, with the messages that they carry."""
