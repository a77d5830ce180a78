"""What the tests of the page's jogging share: gamepads and sliders that are not there, and what the page commands."""

from __future__ import annotations

import time
from typing import Any

from twistarm.viewer import Viewer

PAD = """(state) => {
  const buttons = Array.from({ length: 17 }, (_, i) => {
    const value = state.buttons?.[i] ?? 0;
    return { value, pressed: value > 0.5 };
  });
  const pad = { connected: true, mapping: state.mapping ?? "standard", axes: state.axes ?? [0, 0, 0, 0], buttons };
  navigator.getGamepads = () => [null, pad];
}"""
"""A gamepad that does not exist, in the words of the W3C's Gamepad interface."""

HIDE = """(hidden) => {
  Object.defineProperty(document, "hidden", { value: hidden, configurable: true });
  document.dispatchEvent(new Event("visibilitychange"));
}"""

BESIDE = """() => {
  const slider = document.querySelector(".joint input").cloneNode();
  Object.assign(slider, { id: "beside", disabled: false });
  document.getElementById("joints").append(slider);
}"""
"""The slider of a joint beside the arm, which works while a servo drives."""

AS_OPENED = """() => {
  delete navigator.getGamepads;
  document.activeElement?.blur();
  delete document.hidden;
  document.getElementById("jog").open = false;
  twistarm.panel.showError("");
  document.getElementById("beside")?.remove();
  Object.assign(twistarm.jog, { frame: "base", step: 3 });
  Object.assign(twistarm.jog.line, { slowed: NaN, staled: NaN });
}"""
"""What tests leave behind on the page, undone."""


class Heard:
    """What pages command, as it arrives: (time [s], kind, fields)."""

    def __init__(self, viewer: Viewer) -> None:
        self.messages: list[tuple[float, str, dict[str, Any]]] = []
        self._viewer = viewer
        _ = viewer.commands
        self._take = viewer._server.commands.take
        viewer._server.commands.take = self._record  # type: ignore[method-assign]

    def _record(self, request: Any, sender: str) -> None:
        self.messages.append((time.monotonic(), request.kind, dict(request.fields)))
        self._take(request, sender)

    def close(self) -> None:
        """Hear no more."""
        del self._viewer._server.commands.take

    @property
    def kinds(self) -> list[str]:
        return [kind for _, kind, _ in self.messages]

    def await_kind(self, kind: str) -> None:
        end = time.monotonic() + 10
        while kind not in self.kinds:
            assert time.monotonic() < end, f"no {kind} arrived"
            time.sleep(0.01)

    def quiet(self) -> None:
        """Nothing more comes."""
        count = len(self.messages)
        time.sleep(0.15)  # almost four periods
        assert len(self.messages) == count

    def jog(self) -> dict[str, Any]:
        """The next jog."""
        self.messages.clear()
        self.await_kind("jog")
        return next(fields for _, kind, fields in self.messages if kind == "jog")
