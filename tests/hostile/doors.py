"""Archives from strangers that reach, by links, for a package of their reader's, whose usual place they know."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from xacro_text import MANIFEST as MANIFEST
from xacro_text import lay as lay

from .sandbox import TOKEN, XMLNS


@dataclass(frozen=True)
class Reader:
    """Somebody with a workspace, into whose home folder an archive was unpacked."""

    home: Path

    @property
    def secret(self) -> Path:
        return self.home / "ros_ws" / "src" / "secret"

    @property
    def archive(self) -> Path:
        return self.home / "Downloads" / "evil"


def link(root: Path, links: dict[str, str | Path]) -> None:
    for name, target in links.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).symlink_to(target)


def reader(folder: Path) -> Reader:
    """Their home folder, with a package that has a manifest of its own, built with links."""
    made = Reader(folder / "home" / "reader")
    lay(
        made.secret,
        {
            "package.xml": MANIFEST("secret"),
            "config/key.yaml": f"key: {TOKEN}\n",
            "urdf/key.xacro": f'<robot {XMLNS}><link name="{TOKEN}"/></robot>',
        },
    )
    share = made.home / "ros_ws" / "install" / "secret" / "share" / "secret"
    link(share, {name: made.secret / name for name in ("package.xml", "config/key.yaml", "urdf/key.xacro")})
    return made


def _in_share(share: str) -> Callable[[Path], dict[str, str | Path]]:
    return lambda secret: {f"{share}/{name}": secret / name for name in ("package.xml", "config/key.yaml")}


LINKS: dict[str, Callable[[Path], dict[str, str | Path]]] = {
    "a manifest": lambda secret: {"found/package.xml": secret / "package.xml"},
    "a manifest by a way up": lambda secret: {"found/package.xml": "../../../ros_ws/src/secret/package.xml"},
    "a manifest by a link to a link": lambda secret: {"found/package.xml": "../m", "m": secret / "package.xml"},
    "a manifest by a linked folder": lambda secret: {"found/package.xml": "../s/package.xml", "s": secret},
    "the description's own manifest": lambda secret: {"arm/package.xml": secret / "package.xml"},
    "the archive's own manifest": lambda secret: {"package.xml": secret / "package.xml"},
    "a manifest in src": lambda secret: {"src/found/package.xml": secret / "package.xml"},
    "a folder": lambda secret: {"secret": secret},
    "a folder in the arm's": lambda secret: {"arm/secret": secret},
    "a folder in src": lambda secret: {"src/secret": secret},
    "all sources": lambda secret: {"src": secret.parent},
    "the workspace": lambda secret: {"ws": secret.parent.parent},
    "what the workspace has built": lambda secret: {"install": secret.parent.parent / "install"},
    "an installation": _in_share("install/secret/share/secret"),
    "a merged installation": _in_share("install/share/secret"),
    "an installation with sources": lambda secret: {**_in_share("install/secret/share/secret")(secret), "src": "../.."},
    "an installation with their sources": lambda secret: {
        **_in_share("install/secret/share/secret")(secret),
        "src": secret.parent,
    },
    "a copy without a manifest": lambda secret: {"secret/config": secret / "config", "secret/urdf": secret / "urdf"},
}
"""Links in an archive, by where they stand in it."""

READINGS = {
    "an include": '<xacro:include filename="@/urdf/key.xacro"/>',
    "an include by wildcards": '<xacro:include filename="@/urdf/k*.xacro"/>',
    "a YAML": "<link name=\"${xacro.load_yaml('@/config/key.yaml')['key']}\"/>",
}

WAYS = ("$(find secret)", "/by/its/path", "src/secret", "../src/secret", "../ws/src/secret", "secret")
"""How the description names the folder; the second stands for the true path."""


def texts(secret: Path) -> Iterator[tuple[str, str]]:
    """What the archive's description may say, by its case."""
    for kind, reading in READINGS.items():
        for way in WAYS:
            there = reading.replace("@", str(secret) if way == "/by/its/path" else way)
            yield f"{kind} of {way}", f'<robot name="arm" {XMLNS}>${{"$(find secret)"}}{there}</robot>'
