"""What may be shown: a joint value inside its limits, or decimal text away from them."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from recorded_poses import ask
from twistarm import ArmBuilder
from twistarm.support.errors import LimitError
from twistarm.viewer.stage import Stage

ARM = (
    ArmBuilder("pair")
    .revolute("turn", [0, 0, 1], [0, 0, 0], lower=-1.5, upper=1.5)
    .prismatic("slide", [1, 0, 0], lower=-0.2, upper=0.2)
    .tool(np.eye(4))
    .build()
)


@pytest.mark.parametrize("beyond", [1e-4, 2e-6])
@pytest.mark.parametrize(("name", "limit"), [("turn", 1.5), ("turn", -1.5), ("slide", 0.2), ("slide", -0.2)])
def test_a_little_beyond_a_limit_is_refused(name: str, limit: float, beyond: float) -> None:
    stage, value = Stage(ARM), limit * (1 + beyond / abs(limit))
    with pytest.raises(LimitError, match=f"{name} = .* is outside its limits"):
        ask(stage, "joint", name=name, value=value)
    with pytest.raises(LimitError, match=f"{name} = .* is outside its limits"):
        ask(stage, "theta", theta=[value if joint == name else 0.0 for joint in ARM.joint_names])
    assert_array_equal(stage.theta, ARM.ready)


def test_a_slider_s_end_written_as_decimal_text_is_taken() -> None:
    stage = Stage(ARM)
    ask(stage, "joint", name="turn", value=1.5 + 5e-7)
    ask(stage, "joint", name="slide", value=-0.2 - 5e-7)
    assert_array_equal(stage.theta, [1.5 + 5e-7, -0.2 - 5e-7])
