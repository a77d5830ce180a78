"""`python -m twistarm`: the program."""

from .cli import main

main()
