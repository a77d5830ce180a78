"""The fixtures of the view's tests."""

from recorded_poses import stage
from viewer_page import arm, viewer

__all__ = ["arm", "stage", "viewer"]
