"""Random MJCF that MuJoCo takes: every orientation, defaults, frames, several joints, copies, couplings, keyframes."""

from __future__ import annotations

import numpy as np

TYPES = ("hinge", "hinge", "hinge", "slide", "ball")


class Random:
    """One file from a seed."""

    def __init__(self, seed: int) -> None:
        self.rng = np.random.default_rng(seed)
        self.degrees = bool(self.rng.integers(2))
        self.sequence = "".join(self.rng.choice(list("xyzXYZ"), 3))
        self.bodies, self.joints, self.tip = 0, list[tuple[str, str]](), ""

    def chance(self, share: float) -> bool:
        return bool(self.rng.random() < share)

    def numbers(self, count: int, size: float = 1.0) -> str:
        return " ".join(f"{x:.6g}" for x in self.rng.uniform(-size, size, count))

    def angle(self, size: float = 3.0) -> float:
        return float(self.rng.uniform(-size, size)) * (180 / np.pi if self.degrees else 1.0)

    def place(self) -> str:
        forms = ("quat", "euler", "axisangle", "xyaxes", "zaxis", "")
        form = forms[self.rng.integers(len(forms))]
        text = f' pos="{self.numbers(3, 0.4)}"' if self.chance(0.8) else ""
        if form == "euler":
            return text + f' euler="{self.angle():.5g} {self.angle():.5g} {self.angle():.5g}"'
        if form == "axisangle":
            return text + f' axisangle="{self.numbers(3)} {self.angle():.5g}"'
        return text + (f' {form}="{self.numbers({"quat": 4, "xyaxes": 6, "zaxis": 3}[form])}"' if form else "")

    def joint(self, kind: str) -> str:
        name = f"j{len(self.joints)}"
        self.joints.append((name, kind))
        text = f'<joint name="{name}" type="{kind}"'
        if kind == "ball":
            return text + f' pos="{self.numbers(3, 0.1)}"/>'
        text += f' axis="{self.numbers(3)}"' if self.chance(0.8) else ' class="tilted"'
        text += f' pos="{self.numbers(3, 0.1)}"' if self.chance(0.5) else ""
        turn = self.angle(0.4) if kind == "hinge" else float(self.rng.uniform(-0.2, 0.2))
        text += f' ref="{turn:.5g}"' if self.chance(0.4) else ""
        low, high = sorted((self.angle(1.5), self.angle(1.5))) if kind == "hinge" else (-0.5, 0.75)
        text += f' range="{low:.5g} {high:.5g}"' if self.chance(0.7) else ""
        text += f' limited="{"true" if self.chance(0.5) else "false"}"' if "range=" in text and self.chance(0.3) else ""
        return text + (' actuatorfrcrange="-7 5"/>' if self.chance(0.3) else "/>")

    def geom(self) -> str:
        kind = str(self.rng.choice(["sphere", "capsule", "cylinder", "box", "ellipsoid"]))
        text = f'<geom type="{kind}" size="0.05 0.08 0.03"{self.place()}'
        if kind in ("capsule", "cylinder", "box") and self.chance(0.4):
            text = f'<geom type="{kind}" size="0.04 0.03" fromto="{self.numbers(6, 0.2)}"'
        text += f' {self.rng.choice(["mass", "density"])}="{self.rng.uniform(0.5, 3):.4g}"' if self.chance(0.5) else ""
        return text + (' shellinertia="true"/>' if self.chance(0.2) and kind != "ellipsoid" else "/>")

    def body(self, deep: int, loose: bool = False) -> str:
        self.bodies += 1
        name = f"b{self.bodies}"
        around = ' childclass="soft"' if self.chance(0.2) else ""
        parts = ["<freejoint/>"] if loose else []
        before = len(self.joints)
        kinds = self.rng.choice(TYPES, 1 if self.chance(0.7) else 2)
        for kind in () if loose or self.chance(0.1) else kinds:
            parts.append(self.joint(str(kind)))
            if kind == "ball":
                break
        self.tip = name if len(self.joints) > before else self.tip
        parts += [self.geom() for _ in range(self.rng.integers(1, 3))]
        if self.chance(0.3):
            parts.append(f'<inertial mass="1.5" pos="{self.numbers(3, 0.1)}" diaginertia="0.1 0.12 0.15"/>')
        parts += [f'<site name="s_{name}"{self.place()}/>'] if self.chance(0.5) else []
        inner = [self.body(deep - 1) for _ in range(self.rng.integers(1, 3))] if deep else []
        if inner and self.chance(0.3):
            inner[0] = f"<frame{self.place()}>{inner[0]}</frame>"
        if inner and self.chance(0.15):
            copied = f'<body name="c{name}" pos="0.1 0 0"><joint name="jc{name}" axis="0 1 1"/>{self.geom()}</body>'
            inner.append(f'<replicate count="2" offset="0 0.1 0" euler="0 0 0.3">{copied}</replicate>')
        return f'<body name="{name}"{self.place()}{around}>{"".join(parts)}{"".join(inner)}</body>'

    def text(self) -> str:
        angle = "degree" if self.degrees else "radian"
        rule = ' inertiafromgeom="true"' if self.chance(0.2) else ""
        total = ' settotalmass="9"' if self.chance(0.1) else ""
        body = self.body(3, loose=self.chance(0.1))
        single = [name for name, kind in self.joints if kind != "ball"]
        couple = ""
        if len(single) > 2 and self.chance(0.5):
            a, b, c = self.rng.permutation(single)[:3]
            couple = f'<joint joint1="{a}" joint2="{b}" polycoef="{self.numbers(2)} 0 0 0"/>'
            couple += f'<joint joint1="{c}" polycoef="{self.numbers(1, 0.3)} 1 0 0 0"/>' if self.chance(0.4) else ""
        drives = "".join(
            f'<motor joint="{name}" gear="{self.rng.uniform(-3, 3):.3g}" ctrlrange="-2 3"/>'
            for name in single
            if self.chance(0.3)
        )
        return f"""<mujoco model="random">
<compiler angle="{angle}" eulerseq="{self.sequence}"{rule}{total}/><option gravity="{self.numbers(3, 9.0)}"/>
<default><geom density="800"/><joint armature="0.1"/><default class="tilted"><joint axis="1 1 0"/>
<default class="soft"><geom density="300"/><joint axis="0 1 1"/></default></default></default>
<worldbody><geom type="plane" size="1 1 1"/>{body}</worldbody>
<equality>{couple}</equality><actuator>{drives}</actuator></mujoco>"""
