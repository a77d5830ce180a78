"""Words about slips that are made in several lessons, and the terms of each language in them."""

from __future__ import annotations

PYTHON = {
    "to_radians": "convert the angle with np.radians", "degrees": "np.degrees", "exp": "np.exp",
    "expm": "scipy.linalg.expm", "times": "`*`", "squares": "`*` or `**`", "matmul": "@", "transpose": ".T",
    "eye": "np.eye", "nan": "NaN",
}  # fmt: skip
"""What the terms in braces of a slip's words are called in Python."""

OCTAVE = {
    "to_radians": "convert the angle, or take its sine by sind", "degrees": "rad2deg", "exp": "exp", "expm": "expm",
    "times": "`.*`", "squares": "`.*` or `.^`", "matmul": "*", "transpose": "'", "eye": "eye",
    "nan": "NaN or a singular matrix",
}  # fmt: skip
"""The same in Octave and MATLAB."""

DEGREES = (
    "You {to_radians}, but it is in radians already: the turn comes out 57 times too small. Leave the conversion out."
)
ANGULAR_FIRST = (
    "Your twist is (ω, v), as in Modern Robotics; here the linear part comes first, (v, ω). Swap the halves."
)
ACOS = (
    "Rounding brings the argument of arccos slightly above 1 (or below −1), and the answer is NaN: clamp it with "
    "np.clip(…, -1.0, 1.0) first."
)
NO_CROSS_TERM = (
    "Your Adjoint has no p̂R in its upper right corner: it turns the velocities, but loses the term p × ω in v. Ad = "
    "[R, p̂R; 0, R]."
)
ADJOINT_TRANSPOSED = (
    "You use the transpose of the Adjoint: that is how wrenches are carried. Twists are carried by Ad = [R, p̂R; 0, R] "
    "itself."
)
NO_HOME = (
    "You forgot the home pose: the product of exponentials is the motion of the tool from g_st(0). Multiply by home "
    "at the end."
)
