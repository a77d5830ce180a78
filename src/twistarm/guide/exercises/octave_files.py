"""The tasks for Octave and MATLAB: functions to fill in, and scripts that write their answers."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from ...arm.arm import Arm
from . import every_exercise
from .exercise import Exercise

SCRIPTS = {
    "rotations": ("rotation_z", "zyz", "rodrigues", "change_frame"),
    "rigid_motions": ("homogeneous", "inverse_pose", "transform_points", "tool_point"),
    "manipulator": (
        "twist_exp",
        "adjoint",
        "product_of_exponentials",
        "spatial_jacobian",
        "body_jacobian",
        "damped_step",
        "solve_pose",
    ),
}
"""The scripts, of the guide's sections 2.1.3, 2.2.3 and 4, and the functions that each of them runs."""

FOLDER = Path(__file__).with_name("octave")
"""Folder of the model solutions, one file each."""

MARK = "% --- yours from here on ---\n"
"""Line in a model solution after which the reader's part begins."""

SCRIPT = """% Runs your functions on some instances, and writes what they answer to results_{name}.csv.
% Then: twistarm guide check results_{name}.csv
% Nothing is to be filled in here. It runs in Octave and in MATLAB.

cases = {{ ...
{cases}
}};

lines = {{'# twistarm guide results 1'}};
stopped = false;
for k = 1:numel(cases)
    name = cases{{k}}{{1}};
    given = cases{{k}}{{2}};
    for i = 1:numel(given)
        head = sprintf('%s,%d,argument,%d,%d,%d', name, k, i, size(given{{i}}, 1), size(given{{i}}, 2));
        lines{{end + 1}} = [head, sprintf(',%.17g', given{{i}})];
    end
    try
        answer = feval(name, given{{:}});
        if ischar(answer)
            lines{{end + 1}} = sprintf('%s,%d,error,0,0,0,%s', name, k, answer);
            continue
        end
        if ~(isnumeric(answer) || islogical(answer)) || ~isreal(answer) || ndims(answer) > 2
            error('it returns no matrix of real numbers');
        end
        head = sprintf('%s,%d,answer,0,%d,%d', name, k, size(answer, 1), size(answer, 2));
        lines{{end + 1}} = [head, sprintf(',%.17g', double(answer))];
    catch problem
        stopped = true;
        words = strrep(strrep(problem.message, char(10), ' '), char(13), ' ');
        lines{{end + 1}} = sprintf('%s,%d,error,0,0,0,%s', name, k, words);
    end
end
lines{{end + 1}} = sprintf('# %d cases', numel(cases));
file = fopen('results_{name}.csv', 'w');
fprintf(file, '%s\\n', lines{{:}});
fclose(file);
disp('written: results_{name}.csv; now: twistarm guide check results_{name}.csv');
if stopped && exist('OCTAVE_VERSION', 'builtin')
    disp('A function stopped with an error. If Octave ends with "error: ignoring ...", it speaks of that one.');
end
"""


def octave_files(arm: Arm, seed: int = 0) -> Iterator[tuple[str, str]]:
    """Name and text of every file: the functions without their solutions, and the scripts."""
    for script, names in SCRIPTS.items():
        for name in names:
            yield f"{name}.m", template(octave_solution(name))
        yield f"run_{script}.m", script_text(script, arm, seed)


def octave_solution(name: str) -> str:
    """The model solution of an exercise for Octave and MATLAB."""
    return (FOLDER / f"{name}.m").read_text("utf-8")


def template(solution: str) -> str:
    """The function of a model solution with its own part left out."""
    head, mark, _ = solution.partition(MARK)
    answer = head.split()[1]
    # No error: Octave tells of one that was caught when it ends.
    return f"{head}{mark}    {answer} = 'not written yet';\nend\n"


def script_text(script: str, arm: Arm, seed: int = 0) -> str:
    """The script that runs its functions and writes their answers."""
    exercises = every_exercise()
    cases = [line for name in SCRIPTS[script] for line in _cases(exercises[name], arm, seed)]
    return SCRIPT.format(name=script, cases="\n".join(cases))


def _cases(exercise: Exercise, arm: Arm, seed: int) -> Iterator[str]:
    for arguments in exercise.instances(np.random.default_rng(seed), arm):
        yield f"    {{'{exercise.name}', {{{', '.join(map(_written, arguments))}}}}}, ..."


def _written(value: Any) -> str:
    """A number, a vector as a column, or a matrix by its rows."""
    rows = np.atleast_1d(value)
    rows = rows[:, None] if rows.ndim == 1 else rows
    text = "; ".join(" ".join(repr(float(number)) for number in row) for row in rows)
    return f"[{text}]" if rows.size > 1 else text
