"""Subset STIX Two Math to the font of the course's formulae.

    npm pack @fontsource/stix-two-math && tar xzf fontsource-stix-two-math-*.tgz
    pip install 'fonttools[woff]'
    python tools/math_font.py package/files/stix-two-math-latin-400-normal.woff

It writes `src/twistarm/guide/site/fonts/stix-two-math.woff2`. The table MATH stays, with the variants and parts of tall
brackets and roots. `OFL.txt` beside the font is the package's LICENSE. The font reserves no name. If a later version
does, give the subset another name.
"""

from __future__ import annotations

import sys
from pathlib import Path

from fontTools import subset

FONT = Path(__file__).parents[1] / "src/twistarm/guide/site/fonts/stix-two-math.woff2"

BLOCKS = (
    (0x20, 0x7E),  # Latin letters, digits, signs
    (0xA0, 0xFF),  # × · ± ° ¯
    (0x2C6, 0x2DD),  # hat, dot, tilde
    (0x300, 0x338),  # the same, as combining accents
    (0x391, 0x3F6),  # Greek
    (0x2010, 0x2057),  # dashes, ‖, …, primes
    (0x2061, 0x2064),  # invisible operators
    (0x20D0, 0x20EF),  # vectors above letters
    (0x2100, 0x214F),  # ℝ, ℍ, ℬ and other letters of mathematics
    (0x2190, 0x22FF),  # arrows, operators
    (0x2308, 0x230B),  # brackets of floor and ceiling
    (0x239B, 0x23E1),  # parts of tall brackets
    (0x25A0, 0x25FF),  # squares, circles
    (0x27C0, 0x27FF),  # angle brackets, long arrows
    (0x2A00, 0x2AFF),  # more operators
    (0x1D400, 0x1D7FF),  # letters in italic, bold, script, double-struck
)


def main(source: str) -> None:
    """Write the subset of the font `source`."""
    options = subset.Options(flavor="woff2", hinting=False, layout_features=["*"], name_IDs=["*"])
    font = subset.load_font(source, options)
    subsetter = subset.Subsetter(options)
    subsetter.populate(unicodes=[code for first, last in BLOCKS for code in range(first, last + 1)])
    subsetter.subset(font)
    subset.save_font(font, str(FONT), options)


if __name__ == "__main__":
    main(sys.argv[1])
