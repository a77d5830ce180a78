"""Install this checkout for development into the environment that runs this file, and say how far it is.

python tools/install.py EXTRAS installs `.[EXTRAS]` and compiles the core, side by side: pip is busy with one processor.
Without EXTRAS it compiles alone. The core lands beside the Python of `src/twistarm`, for the processor of this machine;
what has not changed is not compiled again.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).parents[1]
TOOLS = ("cmake>=3.18", "ninja", "nanobind>=2.7", "scikit-build-core>=1.0")
BUILD = ROOT / "build" / "core" / (sys.implementation.cache_tag or "python")

STEPS = {
    r"Collecting (?P<what>[\w.-]+)": "  {what}",
    r"Installing collected packages": "  installing packages …",
    r"\[(?P<step>\d+/\d+)\] Building CXX object \S*/(?P<what>[\w.-]+)\.o": "  core [{step}] {what}",
}
"""What a line of a program's output says, and the line of progress in its place."""


def progress(line: str) -> str | None:
    """A line of output as one of progress, or None for most of them."""
    for pattern, shown in STEPS.items():
        if found := re.match(rf"\s*{pattern}", line):
            return shown.format(**found.groupdict())
    return None


def run(command: Sequence[object], log: Path) -> bool:
    """Whether a program succeeds. `log` takes its output, the terminal its progress, and its last lines if it fails."""
    log.parent.mkdir(parents=True, exist_ok=True)
    with (
        log.open("w", encoding="utf-8") as kept,
        subprocess.Popen(
            [str(word) for word in command], cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
        ) as program,
    ):
        assert program.stdout is not None
        for line in program.stdout:
            kept.write(line)
            if printed := progress(line):
                print(printed, flush=True)
    if program.returncode:
        lines = log.read_text("utf-8").splitlines()[-30:]
        print("\n".join([*lines, f"{command[0]} has failed. All that it said is in {log.relative_to(ROOT)}."]))
    return program.returncode == 0


def pip(*arguments: str, log: str) -> bool:
    """Whether pip has installed `arguments`. Python compiles a module when it imports it first: most never are."""
    command = ("-m", "pip", "install", "--verbose", "--progress-bar=off", "--no-compile", *arguments)
    return run([sys.executable, *command], ROOT / "build" / log)


def compile_core() -> bool:
    """Whether twistarm._core is compiled. An outdated one goes: without it twistarm works, slower, and says so."""
    beside = ROOT / "src" / "twistarm"
    found = {
        name: shutil.which(name, path=Path(sys.executable).parent) or shutil.which(name) for name in ("cmake", "ninja")
    }
    nanobind = subprocess.run([sys.executable, "-m", "nanobind", "--cmake_dir"], capture_output=True, text=True)
    options = {
        "TWISTARM_PYTHON": "ON",
        "TWISTARM_NATIVE": "ON",
        "Python_EXECUTABLE": sys.executable,
        "nanobind_ROOT": nanobind.stdout.strip(),
        "CMAKE_MAKE_PROGRAM": found["ninja"],
        "CMAKE_LIBRARY_OUTPUT_DIRECTORY": beside,
    }
    given = [f"-D{name}={value}" for name, value in options.items()]
    configure = [found["cmake"], "-S", ROOT / "core", "-B", BUILD, "-G", "Ninja", *given]
    done = all(found.values()) and run(configure, BUILD / "configure.log")
    done = done and run([found["cmake"], "--build", BUILD], BUILD / "build.log")
    if not done:
        print("The core is not compiled. twistarm works without it, slower; mend what is said above, then: make core")
        (beside / f"_core{sysconfig.get_config_var('EXT_SUFFIX')}").unlink(missing_ok=True)
    return done


def main(extras: str) -> int:
    """Install, and return 0 if the packages are there; without extras, if the core is compiled."""
    what = "Installing twistarm's packages and compiling its core" if extras else "Compiling the core"
    print(f"{what}. On two cores that takes one to two minutes.", flush=True)
    if not pip(*TOOLS, log="tools.log"):
        return 1
    with ThreadPoolExecutor(1) as beside:
        compiled = beside.submit(compile_core)
        installed = not extras or pip("--no-build-isolation", "--editable", f".[{extras}]", log="packages.log")
    return 0 if installed and (extras or compiled.result()) else 1


if __name__ == "__main__":
    raise SystemExit(main("".join(sys.argv[1:])))
