"""The page's core is the one of the sources."""

from __future__ import annotations

import gzip
import json
import subprocess
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "tools"))
import wasm

MOST, MOST_ZIPPED = 650_000, 220_000  # bytes that a page takes


def test_the_module_is_of_these_sources_and_small() -> None:
    module = wasm.MODULE.read_bytes()
    assert wasm.record(module) == json.loads(wasm.RECORD.read_text("utf-8")), "run `make wasm`"
    assert len(module) <= MOST
    assert len(gzip.compress(module)) <= MOST_ZIPPED


@pytest.mark.slow
def test_the_same_bytes_are_compiled_again(tmp_path: Path) -> None:
    try:
        compiled = wasm.compiled(tmp_path)
    except subprocess.CalledProcessError as error:
        if "pip" not in error.cmd:
            raise
        pytest.skip(f"zig {wasm.ZIG} cannot be installed here")
    assert compiled == wasm.MODULE.read_bytes()
