"""A program's own controls on the pages: sliders, buttons and lines of text."""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import Callable, Iterator
from pathlib import Path
from traceback import extract_tb
from typing import Any, Generic, TypeVar

from ...support.errors import InputError, one_line, unknown_name
from ..protocol.jobs import Job, Progress
from ..protocol.messages import Message
from .show import Part, Route, Show

V = TypeVar("V")

LOG = logging.getLogger("twistarm")
"""Without other settings, Python prints errors of it in the terminal."""


class Control(Generic[V]):
    """A slider, a button or a text on the pages, for use from any thread."""

    def __init__(
        self,
        name: str,
        value: V,
        check: Callable[[V], V],
        post: Callable[[str, Callable[[Any], None]], None],
        call: Callable[..., object] | None = None,
        ends: tuple[float, float] | None = None,
    ) -> None:
        """post: changes the stage as `Server.post` does. ends: of a slider."""
        self.name, self.ends, self.error = name, ends, ""
        self._check, self._post, self._call = check, post, call
        self._value = self._known = check(value)
        post(f"control {name}", lambda stage: stage.controls.shown.update({name: self}))

    @property
    def value(self) -> V:
        """A slider's number, or a text. Setting it shows it on all pages, without a call of `on_change`."""
        return self._value

    @value.setter
    def value(self, value: V) -> None:
        self._value = self._known = self._check(value)
        self._post("value", lambda stage: None)

    def remove(self) -> None:
        """Remove it from the pages. Harmless when repeated."""
        self._post(f"control {self.name}", lambda stage: stage.controls.drop(self))

    def take(self, value: Any) -> None:
        """Take a value from a page. The program does not know it yet."""
        if self.ends is None:
            raise InputError(f"{self.name} is no slider")
        self._value = self._check(value)

    def call(self) -> None:
        """Call the program unless it knows the value. Its error becomes one line."""
        value, known, self._known = self._value, self._known, self._value
        if self._call is None or (self.ends and value == known):
            return
        try:
            self._call(*([value] if self.ends else []))
            self.error = ""
        except (Exception, SystemExit) as error:
            at = "".join(
                f" ({Path(each.filename).name}, line {each.lineno})" for each in extract_tb(error.__traceback__)[1:2]
            )
            self.error = one_line(f"{type(error).__name__}: {error}{at}")
            LOG.error("%s", one_line(f"{self.name}: {self.error}"))

    def entry(self) -> dict[str, Any]:
        """The control for the pages. A button has no value."""
        return {"name": self.name, "value": self._value, "ends": self.ends, "error": self.error}


class Controls(Part):
    """The controls in the order of the program, and those that wait for their callback."""

    def __init__(self) -> None:
        self.shown: dict[str, Control[Any]] = {}
        self.waiting: deque[Control[Any]] = deque()
        self.routes = {"slide": Route(self._slide), "press": Route(self._press)}

    def take_over(self, other: Controls) -> None:
        """Show the controls of another arm's view."""
        self.shown, self.waiting = other.shown, other.waiting

    def drop(self, control: Control[Any]) -> None:
        """Remove a control, unless another has replaced it."""
        if self.shown.get(control.name) is control:
            del self.shown[control.name]

    def _slide(self, show: Show, now: float, name: str, value: float) -> Job:
        self._named(name).take(value)
        return self._press(show, now, name)

    def _press(self, show: Show, now: float, name: str) -> Job:
        """The job calls the program, one callback at a time, in order."""
        self.waiting.append(self._named(name))
        return Job("controls", "calling the program", self._call, lambda result: None)

    def _named(self, name: str) -> Control[Any]:
        if name not in self.shown:
            raise unknown_name("control", name, self.shown, within="the view", listing=", ".join(self.shown))
        return self.shown[name]

    def messages(self, show: Show) -> Iterator[Message]:
        """The controls."""
        yield {"type": "controls", "controls": [control.entry() for control in self.shown.values()]}

    def _call(self, progress: Progress) -> None:
        while self.waiting:
            self.waiting.popleft().call()
