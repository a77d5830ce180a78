"""Colours of a description, by the name of their material, as urdfdom resolves it."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import numpy as np

from ..support.errors import listed
from .document import Reading
from .numerals import floats

Colour = tuple[float, float, float, float]

BYTE = 255.0
"""The largest component where somebody counts to it instead of to 1."""


class Materials:
    """The colours of one robot.

    `note_odd` reports faults.

    A name belongs to its first colour: the robot's, else that of the first visual in the file. Later colours of the
    name are ignored. A material without a name has a separate colour.
    """

    def __init__(self, robot: ET.Element, reading: Reading) -> None:
        self._reading = reading
        self._known: dict[str, Colour] = {}
        self._twice: dict[str, None] = {}
        self._odd: dict[tuple[str, str], None] = {}
        for material in robot.findall("material"):
            self.colour(material)

    def colour(self, material: ET.Element | None) -> Colour | None:
        """The colour of a `<material>`; None where neither it nor its name has one."""
        if material is None:
            return None
        name, own = material.get("name", ""), self._own(material)
        if not name:
            return own
        known = self._known.get(name)
        if known is None:
            if own is not None:
                self._known[name] = own
            return own
        if own not in (None, known):
            self._twice[name] = None
        return known

    def note_odd(self) -> None:
        """One finding for all names with two colours, and one for each invalid colour."""
        if self._twice:
            names = listed(self._twice, 3)
            what = f"{len(self._twice)} material{'s' * (len(self._twice) > 1)} with several colours: {names}"
            remedy = "give each colour a different name"
            self._reading.note("material-twice", None, f"{what}; the first colour of a name counts", remedy)
        for rgba, drawn in self._odd:
            what = f"the colour rgba={rgba[:60]!r} is not four numbers from 0 to 1; {drawn}"
            self._reading.note("bad-colour", None, what, 'write rgba="RED GREEN BLUE ALPHA"', repaired=True)

    def _own(self, material: ET.Element) -> Colour | None:
        element = material.find("color")
        if element is None:
            return None
        rgba = element.get("rgba", "")
        words = len(rgba.split())
        try:
            values = np.array(floats(rgba, 3 if words == 3 else 4))
        except ValueError:
            self._odd[rgba, "it is not used"] = None
            return None
        drawn = "drawn opaque" if words == 3 else ""
        if 1.0 < values.max() <= BYTE and values.min() >= 0.0:
            values[:3] /= BYTE
            values[3:] /= BYTE if values[3:].max(initial=0.0) > 1.0 else 1.0
            drawn = "drawn as if it counted to 255"
        elif not ((values >= 0.0) & (values <= 1.0)).all():
            drawn = "drawn with the nearest that are"
        if drawn:
            self._odd[rgba, drawn] = None
        red, green, blue, alpha = (float(x) for x in np.clip([*values, 1.0][:4], 0.0, 1.0))
        return red, green, blue, alpha
