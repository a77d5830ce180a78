"""roboplan's way round obstacles, in an environment of its own. `python -m benchmarks.obstacles_worker`.

It reads one JSON object per line and answers with one line each, as `worker.py` does:

  {"do": "scene", "urdf", "srdf", "group", "fixed", "acceleration", "objects"}   {"joints"}
  {"do": "plan", "start", "goal", "step", "seconds"}                             {"path", "duration", "ns"} or {"error"}

`urdf` and `srdf` are files. An object is {"name", "kind", "size", "pose"}: a box with its edges, a cylinder with radius
and length, or a sphere with its radius [m], and the pose in the world. It may touch `fixed` links and other objects.
RRT-Connect, shortcuts and TOPP-RA look at states `step` [rad, m] apart. `path` are the corners of the way
(k, n), straight between them. `ns` is processor time.
"""

from __future__ import annotations

import tempfile
from itertools import combinations
from pathlib import Path
from time import process_time_ns
from typing import Any

import numpy as np
import roboplan.core as core
from roboplan.rrt import RRT, RRTOptions
from roboplan.toppra import PathParameterizerTOPPRA, TOPPRAOptions

from .peers import serve

Asked = dict[str, Any]
SHAPES = {
    "box": (core.Box, "addBoxGeometry"),
    "cylinder": (core.Cylinder, "addCylinderGeometry"),
    "sphere": (core.Sphere, "addSphereGeometry"),
}
MOST_NODES = 1_000_000


class Solver:
    """The scene that was asked for last."""

    scene: Any
    group: str

    def answer(self, asked: Asked) -> dict[str, Any]:
        """The answer to one message."""
        return self.made(asked) if asked["do"] == "scene" else self.planned(asked)

    def made(self, asked: Asked) -> dict[str, Any]:
        """Load the arm, and put the objects round it."""
        folder = Path(asked["urdf"]).parent
        self.scene = core.Scene("scene", core.loadUrdfSceneDescription(asked["urdf"], [str(folder)]))
        self.scene.importSrdf(Path(asked["srdf"]).read_text("utf-8"))
        self.group = asked["group"]
        joints = self.scene.getJointGroupInfo(self.group).joint_names
        with tempfile.NamedTemporaryFile("w", suffix=".yaml") as file:
            rows = (f"  {name}: {{max_acceleration: [{asked['acceleration']}]}}" for name in joints)
            file.write("\n".join(["joint_limits:", *rows]))
            file.flush()
            self.scene.importJointLimitsFromConfig(core.loadJointLimitsConfig(file.name))
        for each in asked["objects"]:
            shape, add = SHAPES[each["kind"]]
            pose = np.asfortranarray(each["pose"])
            getattr(self.scene, add)(each["name"], "universe", shape(*each["size"]), pose, np.ones(4))
        names = [each["name"] for each in asked["objects"]]
        fixed = [(link, name) for link in asked["fixed"] for name in names]
        self.scene.setCollisions([*fixed, *combinations(names, 2)], False)
        return {"joints": joints}

    def planned(self, asked: Asked) -> dict[str, Any]:
        """Search a way, shorten it and time it."""
        joints, step = self.scene.getJointGroupInfo(self.group).joint_names, asked["step"]
        ends = [core.JointConfiguration(joints, np.array(asked[end])) for end in ("start", "goal")]
        search = RRTOptions(
            group_name=self.group,
            max_nodes=MOST_NODES,
            collision_check_step_size=step,
            max_planning_time=asked["seconds"],
            rrt_connect=True,
        )
        shorten = core.PathShortcuttingOptions(group_name=self.group, max_step_size=step)
        begin = process_time_ns()
        found = RRT(self.scene, search).plan(*ends)
        path = core.PathShortcutter(self.scene, shorten).shortcut(found)
        motion = PathParameterizerTOPPRA(self.scene, self.group).generate(path, TOPPRAOptions())
        took = process_time_ns() - begin
        return {"path": [each.tolist() for each in path.positions], "duration": motion.times[-1], "ns": took}


if __name__ == "__main__":
    serve(Solver().answer)
