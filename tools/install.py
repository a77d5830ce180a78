"""Install this checkout into the environment that runs this file, and say how far it is.

python tools/install.py EXTRAS [LOG] installs `.[EXTRAS]` for development. pip is silent while it compiles, so this
reads what pip logs and prints a line for each package and each compiled file. LOG keeps all of it.
"""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]

STEPS = {
    r"Collecting (?P<what>[\w.-]+)": "package",
    r"\[\s*(?P<step>[\d/%]+)\] Building CXX object \S*/(?P<what>[\w.-]+)\.o": "compiled",
    r"(?P<what>Installing collected packages)": "last",
}
"""What a line of pip's log says, and which kind of step that is."""


def progress(line: str) -> str | None:
    """A line of pip's log as one of progress, or None for most of them."""
    for pattern, kind in STEPS.items():
        found = re.match(rf"\s*{pattern}", line)
        if found and kind == "compiled":
            return f"  core [{found['step']}] {found['what']}"
        if found:
            return f"  {found['what']}" + (" …" if kind == "last" else "")
    return None


def main(extras: str, log: str) -> int:
    """Install, and return pip's exit code."""
    print("Installing twistarm and its packages, and compiling its core. On two cores that takes some four minutes.")
    command = [sys.executable, "-m", "pip", "install", "--verbose", "--progress-bar=off", "--editable", f".[{extras}]"]
    file = ROOT / log
    file.parent.mkdir(parents=True, exist_ok=True)
    with (
        file.open("w", encoding="utf-8") as kept,
        subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as pip,
    ):
        assert pip.stdout is not None
        for line in pip.stdout:
            kept.write(line)
            printed = progress(line)
            if printed:
                print(printed, flush=True)
    if pip.returncode:
        print("".join(file.read_text("utf-8").splitlines(keepends=True)[-30:]), end="")
        print(f"pip has failed. All that it said is in {log}.")
    return pip.returncode


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1], *(sys.argv[2:] or ["build/install.log"])))
