"""`collisions`: the pairs of links that are checked, and those that collide."""

from __future__ import annotations

from typing import Annotated, Any

from ...arm.arm import Arm
from ...collision import Scene
from ...collision.survey import Survey, srdf_text, survey
from ..options import Json, Radians, SceneFile, takes_arm
from ..output import console, finding_json, joint_heads, literal, print_json, progress_bar, say, table, theta_values
from ..outputs import Force, Output, outputs_of
from ..quantities import quantity, whole
from ..wording import words

Margin = Annotated[float, quantity("m", "Distance below which a pair collides.", zero=True)]
Samples = Annotated[int, whole(1, 1_000_000, "Random configurations to check.")]


@takes_arm
def collisions(
    arm: Arm,
    scene: SceneFile = None,
    margin: Margin = 0.0,
    samples: Samples = 2000,
    output: Output = None,
    force: Force = False,
    rad: Radians = False,
    json: Json = False,
) -> None:
    """List which pairs of links are not checked and why, and which collide; -o ARM.srdf writes the former."""
    outputs = outputs_of(output, {"srdf": (".srdf",)}, force=force, json=json, over_description=True)
    with progress_bar("allowed pairs") as progress:
        if scene is None:
            made = Scene(arm, margin=margin, progress=progress)
        else:
            made = Scene.load(arm, scene, margin=margin or None, progress=progress)
        made.find_allowed_pairs()
    with progress_bar("configurations") as progress:
        found = survey(made, samples, progress=progress)
    written = outputs.write({"srdf": lambda: srdf_text(made)})
    if json:
        print_json(_as_json(made, found))
    else:
        _print(made, found, rad)
    outputs.say(written)


def _as_json(scene: Scene, found: Survey) -> dict[str, Any]:
    return {
        "arm": scene.arm.name,
        "allowed": [{"links": pair, "reason": reason} for pair, reason in scene.allowed.items()],
        "samples": found.samples,
        "share": found.share,
        "colliding": [vars(pair) for pair in found.pairs],
        "findings": [finding_json(finding) for finding in scene.findings],
    }


def _print(scene: Scene, found: Survey, radians: bool) -> None:
    say(f"{scene.arm.name}: {len(scene.allowed)} pairs of links are not checked")
    for reason in dict.fromkeys(scene.allowed.values()):
        pairs = [f"{a} – {b}" for (a, b), why in scene.allowed.items() if why == reason]
        console().print(literal(f"{reason}: {', '.join(pairs)}"))
    say(f"collides in {100.0 * found.share:.1f} % of {found.samples} random configurations")
    rows = [
        [
            f"{pair.links[0]} – {pair.links[1]}",
            f"{100.0 * pair.share:.1f} %",
            theta_values(scene.arm, pair.theta, radians, digits=3),
        ]
        for pair in found.pairs
    ]
    if rows:
        columns = ["pair", "share", "for example at"]
        order = f"examples as in --theta: {', '.join(joint_heads(scene.arm, radians))}"
        console().print(table("pairs that collide", columns, rows, text=columns[::2], caption=order))
    for found_one in scene.findings:
        console().print(literal(words(found_one.text)))
