"""The last line of an example: with --view on its command line its motion plays in the browser until Ctrl-C."""

import sys

from twistarm import Arm, Trajectory
from twistarm.viewer import Viewer


def play_if_asked(arm: Arm, motion: Trajectory) -> None:
    """Play the motion over and over, the tool's path drawn, where the program was called with --view."""
    if "--view" in sys.argv[1:]:
        with Viewer(arm, motion(0.0)) as viewer:
            viewer.show_path(motion)
            viewer.play(motion, loop=True)
            viewer.wait()
