"""An arm compared with other engines and with its golden file."""
