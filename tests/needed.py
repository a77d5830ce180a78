"""What tests need of the machine: without it they skip, or fail where everything is required."""

import os
import shutil
from typing import NoReturn

import pytest

COMPILER = next((name for name in ("c++", "g++", "clang++") if shutil.which(name)), "")
"""The system's C++ compiler, or nothing."""


def absent(reason: str) -> NoReturn:
    """Skip the test, or fail it under TWISTARM_REQUIRE_ALL=1."""
    (pytest.fail if os.environ.get("TWISTARM_REQUIRE_ALL") else pytest.skip)(reason)
