"""What every room stands on: errors, checked arguments, files, strict JSON and CSV, interrupts. Knows no robot."""
