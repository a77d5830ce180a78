"""A stage on which three poses are recorded, and how a test asks it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from twistarm import Arm
from twistarm.support.strict_json import encode
from twistarm.viewer.jobs import Job
from twistarm.viewer.messages import parse
from twistarm.viewer.stage import Stage
from viewer_page import THETA

HOME, REACH, LEFT = (0.0, 0.0, 0.0), (1.0, 1.0, 0.1), (2.0, -1.0, 0.2)


def ask(stage: Stage, kind: str, /, **fields: Any) -> Job | None:
    """A request as it would arrive, checked by the schema."""
    usual = {"corner": 0.0, "linear_speed": 0.0, "torques": False, "payload": 0.0} if kind == "plan" else {}
    return stage.handle(parse(encode({"type": kind, **usual, **fields})), now=0.0)


def said(stage: Stage, kind: str) -> dict[str, Any]:
    (message,) = [message for message in stage.messages() if message["type"] == kind]
    return message


def names(stage: Stage) -> list[str]:
    return [pose["name"] for pose in said(stage, "program")["poses"]]


def done(job: Job | None) -> None:
    """Do a job at once, as its thread and the loop would; most targets are answered without one."""
    if job is not None:
        job.finish(job.work(lambda share: None))


@pytest.fixture
def stage(arm: Arm) -> Stage:
    """With three poses recorded."""
    stage = Stage(arm, THETA)
    for name, theta in (("home", HOME), ("reach", REACH), ("left", LEFT)):
        stage.show(np.array(theta))
        ask(stage, "record", name=name)
    return stage
