"""Colours and sizes of shapes: as Pinocchio's parser (urdfdom) resolves them, or named for what they are."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio
import pytest

from twistarm.description.urdf import read_description
from urdf_text import two_joints, write

RED, BLUE = "1 0 0 1", "0 0 1 0.5"


def material(name: str, rgba: str = "") -> str:
    colour = f'<color rgba="{rgba}"/>' if rgba else ""
    return f'<material name="{name}">{colour}</material>'


def drawing(*links: str, top: str = "", shape: str = '<box size="1 1 1"/>') -> str:
    """The two-joint arm with visuals of these materials on its first links."""
    text = two_joints().replace('<link name="base_link"/>', f'{top}<link name="base_link"/>')
    for name, materials in zip(("base_link", "upper"), links, strict=False):
        parts = "".join(f"<visual><geometry>{shape}</geometry>{one}</visual>" for one in materials.split("|"))
        text = text.replace(f'<link name="{name}"/>', f'<link name="{name}">{parts}</link>')
    return text


NAMED = {
    "the robot's own against a link's": drawing(material("m", BLUE), top=material("m", RED)),
    "a link's against another's": drawing(material("m", RED), material("m", BLUE)),
    "two of one link": drawing(material("m", RED) + "|" + material("m", BLUE), material("m")),
    "no name": drawing(material("", RED), material("", BLUE)),
}


@pytest.mark.parametrize("case", NAMED)
def test_a_name_means_its_first_colour(case: str, tmp_path: Path) -> None:
    path = write(tmp_path, NAMED[case])
    model = pinocchio.buildModelFromXML(path.read_text())
    drawn = pinocchio.buildGeomFromUrdf(model, str(path), pinocchio.GeometryType.VISUAL).geometryObjects
    description = read_description(path)
    ours = [shape.colour for link in description.links.values() for shape in link.visuals]
    np.testing.assert_allclose(ours, [one.meshColor for one in drawn])
    twice = len({RED, BLUE} & {rgba for rgba in (RED, BLUE) if rgba in NAMED[case]}) == 2 and case != "no name"
    assert [one.code for one in description.findings if one.code == "bad-geometry"] == ["bad-geometry"] * twice


def test_a_name_that_is_given_later_colours_nothing_before(tmp_path: Path) -> None:
    description = read_description(write(tmp_path, drawing(material("m"), material("m", RED))))
    assert [description.links[name].visuals[0].colour for name in ("base_link", "upper")] == [None, (1, 0, 0, 1)]
    assert ["'m'" in one.what for one in description.findings if one.code == "bad-geometry"] == [True]


COLOURS = {"0.1 0.2 0.3": (0.1, 0.2, 0.3, 1.0), "2 0.2 0 1": (1.0, 0.2, 0.0, 1.0), "red": None}


@pytest.mark.parametrize("rgba", COLOURS)
def test_a_colour_that_is_none_is_a_finding(rgba: str, tmp_path: Path) -> None:
    text = drawing("x").replace("x</visual>", f'<material name=""><color rgba="{rgba}"/></material></visual>')
    description = read_description(write(tmp_path, text))
    assert [one.code for one in description.findings].count("bad-geometry") == 1
    assert description.links["base_link"].visuals[0].colour == COLOURS[rgba]


SIZES = {
    '<box size="0 1 1"/>': ((0, 1, 1), ""),
    '<box size="-1 2 3"/>': ((1, 2, 3), "with positive sizes"),
    '<cylinder radius="1" length="-2"/>': ((1, 2), "with positive sizes"),
    '<box size="0 0 1"/>': (None, "it is invisible"),
}


@pytest.mark.parametrize("shape", SIZES)
def test_a_size_that_is_none_is_told(shape: str, tmp_path: Path) -> None:
    description = read_description(write(tmp_path, drawing("", shape=shape)))
    size, told = SIZES[shape]
    assert [one.size for one in description.links["base_link"].visuals] == ([] if size is None else [size])
    whats = [one.what for one in description.findings if one.code == "bad-geometry"]
    assert len(whats) == bool(told)
    assert all(told in what for what in whats)
