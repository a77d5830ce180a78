"""The command line: the only place that prints or exits."""

import signal


def main() -> None:
    """Entry point of the `twistarm` program.

    Loading takes most of a second and needs no clean-up, so Ctrl-C ends the process at once.
    """
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    from .application import program

    program()
