"""Descriptions written as one line: links, and how each moves on the one before it.

`base R> upper P> fore [-> camera | R> hand*]`: R revolute, C continuous, P prismatic, F floating, - fixed, with m a
mimic of the last joint that moves by itself; brackets where the tree forks; * for a link with a shape. The branches of
a fork sit alternately left and right, and move towards each other.
"""

from __future__ import annotations

import re

from urdf_text import joint, robot

KINDS = {"R": "revolute", "C": "continuous", "P": "prismatic", "F": "floating", "-": "fixed"}
SHAPE = '<visual><geometry><box size=".1 .1 .1"/></geometry></visual>'


def skeleton(text: str) -> str:
    """The URDF of a description written as one line."""
    links: list[str] = []
    parts: list[str] = []
    forks: list[list[int]] = []  # the link that branches, and which branch this is
    on, kind, master = -1, "", ""
    for token in re.findall(r"[\[\]|]|[RCPF-]m?>|[^\s\[\]|]+", text):
        if token == "[":
            forks.append([on, 0])
        elif token == "|":
            forks[-1][1] += 1
            on = forks[-1][0]
        elif token == "]":
            on = forks.pop()[0]
        elif token.endswith(">"):
            kind = token
        else:
            branch = forks[-1][1] if forks and forks[-1][0] == on else None
            links.append(token)
            if kind:
                parts.append(_joint(links[on], token, kind, branch, master))
                master = master if "m" in kind or kind == "->" else f"to {token.rstrip('*')}"
            on = len(links) - 1
    shaped = robot(*parts, links=tuple(link.rstrip("*") for link in links))
    for link in links:
        name = f'<link name="{link.rstrip("*")}"'
        shaped = shaped.replace(f"{name}/>", f"{name}>{SHAPE}</link>") if link.endswith("*") else shaped
    return shaped


def _joint(parent: str, child: str, kind: str, branch: int | None, master: str) -> str:
    side = 0.0 if branch is None else 0.05 * (-1) ** branch
    axis = f"0 {1 if branch is None else (-1) ** branch} 0" if kind[0] == "P" or branch is None else "0 0 1"
    inside = f'<mimic joint="{master}"/>' if "m" in kind else ""
    inside += "" if KINDS[kind[0]] in ("fixed", "floating") else f'<axis xyz="{axis}"/>'
    if KINDS[kind[0]] in ("revolute", "prismatic"):
        inside += '<limit lower="-1" upper="1" velocity="2" effort="3"/>'
    parent, child = parent.rstrip("*"), child.rstrip("*")
    return joint(f"to {child}", parent, child, KINDS[kind[0]], inside, xyz=f"0.05 {side} 0.2")
