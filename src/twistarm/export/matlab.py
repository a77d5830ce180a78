"""An arm as a function of MATLAB and Octave: screws, forward kinematics, Jacobians, test vectors."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from ..arm.arm import Arm
from ..arm.baking import digest_of
from ..support.checks import Array
from ..support.errors import InputError, printable

SUFFIX = ".m"

LONGEST = 63
"""Most characters of a name in MATLAB."""

KEYWORDS = """
    break case catch classdef continue do else elseif end enumeration events for function global if methods otherwise
    parfor persistent properties return spmd switch try unwind_protect unwind_protect_cleanup until while
"""
"""Keywords of MATLAB and Octave."""

VECTORS = 5
"""Configurations with which the file tests itself: the ready pose, and random ones inside the limits."""

TOLERANCE = 1e-9
"""Tolerance of the test [m, and none]. Rounding is far smaller, a wrong sign far larger."""


def matlab_text(arm: Arm, file: str | None = None) -> str:
    """The text of a file with this name, by default the arm's. MATLAB calls a function by its file name.

    The test vectors are Pinocchio's where the arm has a description. InputError for a name that no function can have.
    """
    name = _function_name(arm.name) if file is None else Path(file).stem
    if name != (better := _function_name(name)):
        raise InputError(
            f"MATLAB calls a function by its file's name, of letters, digits and _: {name!r} is none; "
            f"call the file {better}{SUFFIX}"
        )
    theta = np.vstack([arm.ready, arm.random_theta(0, VECTORS - 1)])
    by_pinocchio = arm.description is not None
    g, spatial, body = (
        arm.by_pinocchio(theta)
        if by_pinocchio
        else (arm.fk(theta), arm.spatial_jacobian(theta), arm.body_jacobian(theta))
    )
    return _TEMPLATE.format(
        name=name,
        title=name.upper(),
        arm=printable(arm.name),
        base=printable(arm.base),
        tip=printable(arm.tip),
        order=", ".join(f"{printable(joint)} [{unit}]" for joint, unit in zip(arm.joint_names, arm.units, strict=True)),
        digest=digest_of(arm),
        name_text=_text(arm.name),
        joint_names=_texts(arm.joint_names),
        units=_texts(arm.units),
        screws=_matrix(arm.screws),
        home=_matrix(arm.home),
        coupling=_matrix(arm.coupling.A),
        limits="\n".join(
            f"arm.{field} = {_matrix(getattr(arm.limits, field)[None])};"
            for field in ("lower", "upper", "velocity", "acceleration", "effort")
        ),
        ready=_matrix(arm.ready[None]),
        judge="Pinocchio" if by_pinocchio else "twistarm",
        tolerance=repr(TOLERANCE * max(1.0, arm.reach)),
        theta=_matrix(theta),
        g=_matrix(np.hstack(list(g))),
        spatial=_matrix(np.hstack(list(spatial))),
        body=_matrix(np.hstack(list(body))),
    )


def _function_name(name: str) -> str:
    """The name itself if MATLAB and Octave allow it for a function, or one near it."""
    identifier = re.sub(r"[^A-Za-z0-9_]+", "_", name).lstrip("_")[:LONGEST] or "arm"
    return f"arm_{identifier}"[:LONGEST] if identifier[0].isdigit() or identifier in KEYWORDS.split() else identifier


def _matrix(rows: Array) -> str:
    """A matrix, a line for each of several rows."""
    lines = [", ".join(map(_number, row)) for row in rows]
    return f"[{lines[0]}]" if len(lines) == 1 else "[\n    " + "\n    ".join(lines) + "]"


def _number(value: float) -> str:
    return repr(float(value)) if np.isfinite(value) else "-Inf" if value < 0 else "Inf"


def _texts(texts: Iterable[str]) -> str:
    return "{" + ", ".join(map(_text, texts)) + "}"


def _text(text: str) -> str:
    """A text between single quotes, which only a quote can end."""
    return "'" + printable(text).replace("'", "''") + "'"


_TEMPLATE = """\
function arm = {name}()
% {title}  The arm {arm} from {base} to {tip}, for MATLAB and Octave, written by twistarm.
%
%   arm = {name}();
%   g  = arm.fk(theta);                % 4 x 4, the tool seen from the base
%   Js = arm.spatial_jacobian(theta);  % 6 x n, Vs = Js * theta_dot
%   Jb = arm.body_jacobian(theta);     % 6 x n, Vb = Jb * theta_dot
%   arm.check();                       % an error unless the test vectors below, by {judge}, are met
%
% theta: {order}.
% Twists are (v; w), linear part first, as in Murray, Li & Sastry: g(theta) = exp(xi_1 x_1) ... exp(xi_m x_m) home with
% x = A * theta. The (w; v) of Lynch & Park are arm.screws([4 5 6 1 2 3], :).

arm.name = {name_text};
arm.digest = '{digest}';  % of the arm.json that twistarm bakes of the same arm
arm.joint_names = {joint_names};
arm.units = {units};
arm.screws = {screws};
arm.home = {home};
arm.A = {coupling};

% Limits [rad or m, and per s, s^2; N m or N], Inf where none is given; a pose to start from.
{limits}
arm.ready = {ready};

arm.fk = @(theta) fk(arm, theta);
arm.spatial_jacobian = @(theta) spatial_jacobian(arm, theta);
arm.body_jacobian = @(theta) body_jacobian(arm, theta);
arm.check = @() check(arm);
end


function g = fk(arm, theta)
% The product of exponentials; Murray, Li & Sastry, eq. 3.3.
x = joint_values(arm, theta);
g = eye(4);
for i = 1:numel(x)
    g = g * exponential(arm.screws(:, i), x(i));
end
g = g * arm.home;
end


function J = spatial_jacobian(arm, theta)
% Column i is the screw of joint i as the joints before it have moved it; Murray, Li & Sastry, section 3.4.1.
x = joint_values(arm, theta);
J = zeros(6, numel(x));
g = eye(4);
for i = 1:numel(x)
    J(:, i) = adjoint_of(g) * arm.screws(:, i);
    g = g * exponential(arm.screws(:, i), x(i));
end
J = J * arm.A;
end


function J = body_jacobian(arm, theta)
% Jb = Ad(inv(g)) * Js.
g = fk(arm, theta);
R = g(1:3, 1:3);
J = adjoint_of([R', -R' * g(1:3, 4); 0, 0, 0, 1]) * spatial_jacobian(arm, theta);
end


function x = joint_values(arm, theta)
n = numel(arm.joint_names);
if ~isnumeric(theta) || numel(theta) ~= n || ~all(isfinite(theta(:)))
    error('twistarm:theta', 'theta must be %d finite numbers: %s', n, strjoin(arm.joint_names, ', '));
end
x = arm.A * theta(:);
end


function g = exponential(xi, x)
% exp of the twist xi times x; Murray, Li & Sastry, eq. 2.32 and 2.36.
v = xi(1:3);
w = xi(4:6);
rate = norm(w);
if rate == 0
    g = [eye(3), v * x; 0, 0, 0, 1];
    return
end
K = skew(w / rate);
phi = rate * x;
versine = 2 * sin(phi / 2)^2;
R = eye(3) + sin(phi) * K + versine * K * K;
p = (phi * eye(3) + versine * K + (phi - sin(phi)) * K * K) * v / rate;
g = [R, p; 0, 0, 0, 1];
end


function Ad = adjoint_of(g)
R = g(1:3, 1:3);
Ad = [R, skew(g(1:3, 4)) * R; zeros(3), R];
end


function S = skew(w)
S = [0, -w(3), w(2); w(3), 0, -w(1); -w(2), w(1), 0];
end


function off = check(arm)
% How far the functions above are from the test vectors; an error where that is more than {tolerance}.
theta = {theta};
g = {g};
spatial = {spatial};
body = {body};
n = size(theta, 2);
off = 0;
for k = 1:size(theta, 1)
    of_g = fk(arm, theta(k, :)) - g(:, 4 * k - 3:4 * k);
    of_spatial = spatial_jacobian(arm, theta(k, :)) - spatial(:, n * (k - 1) + 1:n * k);
    of_body = body_jacobian(arm, theta(k, :)) - body(:, n * (k - 1) + 1:n * k);
    errors = abs([of_g(:); of_spatial(:); of_body(:)]);
    errors(isnan(errors)) = Inf;
    off = max([off; errors]);
end
if ~(off <= {tolerance})
    error('twistarm:check', '%s is %g away from its test vectors', arm.name, off);
end
end
"""
