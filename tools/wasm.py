"""Compile the core for the page by a pinned zig: the page's arm.wasm, and core/wasm/arm.wasm.json, what it is made of.

The bytes follow from the sources, the flags and the zig alone. `make wasm` runs this after a change of the sources.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import subprocess
import sys
import venv
from pathlib import Path

ROOT = Path(__file__).parents[1]
CORE, BUILD = ROOT / "core", ROOT / "build" / "wasm"
MODULE = ROOT / "src" / "twistarm" / "viewer" / "page" / "arm.wasm"
RECORD = CORE / "wasm" / "arm.wasm.json"
ZIG = "0.17.1"
UNITS = ("wasm/module.cpp", "wasm/engine.cpp", "bindings/kernels.cpp", "bindings/conclusion.cpp")
# -Os would save a quarter of the bytes and cost half of the speed.
FLAGS = (
    "-target", "wasm32-wasi", "-mexec-model=reactor", "-std=c++17", "-O2", "-msimd128", "-fno-exceptions", "-fno-rtti",
    "-fno-math-errno", "-ffp-contract=off", "-DNDEBUG", "-DTWISTARM_KERNELS=baseline", "-Iinclude", "-s",
)  # fmt: skip


def sources() -> list[Path]:
    """The units and, of the core's own files, what they include."""
    found, left = set(), [CORE / unit for unit in UNITS]
    while left:
        file = left.pop().resolve()
        if file in found:
            continue
        found.add(file)
        for name in re.findall(r'^\s*#include "(.*)"', file.read_text("utf-8"), flags=re.MULTILINE):
            left += [path for path in (file.parent / name, CORE / "include" / name) if path.is_file()]
    return sorted(found)


def record(module: bytes) -> dict[str, object]:
    """What `module` is made of, if it is compiled now."""
    digest = hashlib.sha256()
    for file in sources():
        text = file.read_text("utf-8")  # with the same ends of lines on every system
        digest.update(f"{file.relative_to(CORE).as_posix()}\n{len(text)}\n{text}".encode())
    made = hashlib.sha256(module).hexdigest()
    return {"sources": digest.hexdigest(), "flags": " ".join(FLAGS), "zig": ZIG, "module": made}


def compiled(into: Path) -> bytes:
    """The module, compiled into that folder. CalledProcessError where zig is not installed and cannot be."""
    python = BUILD / "venv" / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    if not python.exists():
        venv.create(BUILD / "venv", with_pip=True)
    pip = [python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", f"ziglang=={ZIG}"]
    subprocess.run(pip, check=True)
    out, caches = into / MODULE.name, {f"ZIG_{which}_CACHE_DIR": str(BUILD / "cache") for which in ("LOCAL", "GLOBAL")}
    subprocess.run(
        [python, "-m", "ziglang", "c++", *FLAGS, "-o", out, *UNITS], cwd=CORE, env={**os.environ, **caches}, check=True
    )
    return out.read_bytes()


if __name__ == "__main__":
    BUILD.mkdir(parents=True, exist_ok=True)
    MODULE.write_bytes(compiled(BUILD))
    RECORD.write_text(json.dumps(record(MODULE.read_bytes()), indent=2) + "\n", encoding="utf-8")
    print(f"{MODULE.relative_to(ROOT)}: {MODULE.stat().st_size} bytes", file=sys.stderr)
