"""The command line: the only place that prints or exits."""

import signal


def main() -> None:
    """Entry point of the `twistarm` program.

    While it is loaded, most of a second, there is nothing to put in order: Ctrl-C ends the process at once.
    """
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    from .application import program

    program()
