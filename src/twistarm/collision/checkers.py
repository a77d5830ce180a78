"""The checkers of a scene, made once for the bodies that are present, and the pairs that they check."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import combinations
from typing import TypeVar

import numpy as np

from ..arm.arm import Arm
from ..arm.bodies import Body, Shapes
from ..arm.checker import Checker
from ..arm.pinocchio_model import import_pinocchio
from ..description.tree import Pair, sorted_pair
from ..support.checks import Array, as_number, require_callback, require_mapping
from .allowed_pairs import allowed_pairs
from .near_pairs import NearPairs
from .obstacles import Obstacles
from .swept import Sweep, pair_speeds

T = TypeVar("T")


class Checkers(Obstacles):
    """The bodies of a robot and of obstacles, their margins, and the checkers of all pairs that are not allowed."""

    def __init__(
        self, arm: Arm, margin: float | Mapping[str, float], exact: bool, progress: Callable[[float], object] | None
    ) -> None:
        super().__init__(arm, exact)
        if isinstance(margin, Mapping):
            given = require_mapping(margin, "margin", '{"forearm": 0.02}')
            margin = {name: as_number(value, f"margin[{name!r}]", 0.0) for name, value in given.items()}
        self._margin = margin if isinstance(margin, dict) else as_number(margin, "margin", 0.0)
        self._progress = require_callback(progress, "progress", "(fraction)")
        shapes = Shapes(import_pinocchio().coal, exact=self.exact)
        self._links = tuple(shapes.of_links(self._description, arm.reach))
        self._unreadable: Mapping[str, list[str]] = shapes.unreadable
        self._found_pairs: Mapping[Pair, str] | None = None

    @property
    def allowed(self) -> Mapping[Pair, str]:
        """Sorted pairs that are not checked, and why: "SRDF", "Adjacent", "Default", "Always", "Never", or a reason."""
        return {**self.find_allowed_pairs(), **self._allowed_too}

    def find_allowed_pairs(self) -> Mapping[Pair, str]:
        """The pairs of links that the SRDF, the scene's file, or the rules of `allowed_pairs` exempt.

        They are found once, with `progress`, at this call or at the first question.
        """
        if self._found_pairs is None and self.arm.disabled_collisions:
            self._found_pairs = dict.fromkeys(sorted(self.arm.disabled_collisions), "SRDF")
        if self._found_pairs is None:
            given = self.arm, self._model, self._description, self._links
            self._found_pairs = allowed_pairs(*given, progress=self._progress)
        return self._found_pairs

    @property
    def links(self) -> tuple[Body, ...]:
        """The bodies of the robot's links."""
        return self._links

    @property
    def largest_margin(self) -> float:
        """The largest margin of a pair [m]."""
        return max(self._checker.margins, default=0.0)

    @property
    def near_pairs(self) -> NearPairs:
        """What finds the pairs that are near at a configuration."""
        return self._kept("near", lambda: NearPairs(self._model, self._checker, self._most))

    def checks(self, clearance: float) -> Callable[[Array], bool]:
        """A quick check of one configuration (n,): whether every pair keeps its margin and this clearance [m]."""
        checker, q = self._sweep.checker(clearance), self._model.q
        return lambda theta: not checker.collides(q(theta))

    def _kept(self, what: str, make: Callable[[], T]) -> T:
        """What `make` makes of the present bodies, made once."""
        made = self._cache  # another thread may replace it while `make` runs
        if what not in made:
            made[what] = make()
        return made[what]

    def _base(self, theta: Array) -> Array:
        """The base's pose (4, 4) in Pinocchio's world."""

        def there() -> Array:
            base = self.arm.base
            return self._model.link_poses([self._model.q(theta)], self._description.root, [base])[base][0]

        moved = self._kept("moved", lambda: bool(self._joint_of(self.arm.base)))
        return there() if moved else self._kept("base", there)

    @property
    def _checker(self) -> Checker:
        return self._kept("checker", self._make_checker)

    def _make_checker(self) -> Checker:
        bodies = (*self._links, *(tile for body in self._obstacles.values() for tile in body.tiles))
        for name in () if isinstance(self._margin, float) else self._margin:
            if name not in self._known_obstacles:
                self._description.require_link(name, "margin")

        def exempt(first: Body, second: Body) -> bool:
            pair = sorted_pair(first.name, second.name)
            if pair in self._allowed_too:
                return True
            if first.obstacle or second.obstacle:
                touching = self._touching
                return second.name in touching.get(first.name, ()) or first.name in touching.get(second.name, ())
            return pair in self.find_allowed_pairs()

        joints = [self._joint_of(body.carrier) for body in bodies]
        pairs = [
            (i, j)
            for i, j in combinations(range(len(bodies)), 2)
            if joints[i] != joints[j] and not exempt(bodies[i], bodies[j])
        ]
        # theta moves neither body of some pairs against the other, such as a passive wheel and the ground.
        speeds = pair_speeds(self._model, bodies, pairs, self._most)
        pairs = [pair for pair, row in zip(pairs, speeds, strict=True) if row.any()]
        margin = self._margin
        own = [margin if isinstance(margin, float) else margin.get(body.name, 0.0) for body in bodies]
        return Checker(self._model, bodies, pairs, [max(own[i], own[j]) for i, j in pairs])

    @property
    def _sweep(self) -> Sweep:
        return self._kept("sweep", lambda: Sweep(self._checker, self._model, self._most))

    @property
    def _most(self) -> Array:
        """The greatest |theta| (n,) inside the arm's limits, and a little more, as bounds of motions are not tight."""
        return 1.1 * np.abs(self.arm.sampling_bounds).max(axis=0)
