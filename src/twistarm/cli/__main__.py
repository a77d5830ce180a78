"""`python -m twistarm.cli`: the program."""

from . import main

main()
