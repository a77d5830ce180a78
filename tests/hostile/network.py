"""Attacks on the view's server, each a program of sockets: `python -m hostile.network NAME HOST PORT TOKEN SECONDS`.

Those of `STRANGERS` do not know the token. Those of `MEMBERS` do: a page of another computer's, to which the address
was given. `SILENT` ones hold what they have and send next to nothing.
"""

from __future__ import annotations

import os
import random
import resource
import sys

from .members import MEMBERS
from .strangers import STRANGERS
from .target import OTHER, Target

SILENT = {
    "idle", "of_many_peers", "half_open", "half_a_head", "slow_head", "slow_headers", "slow_body", "slow_chunks",
    "promised_body", "tls", "pages_without_end", "mute_pages", "half_a_frame", "slow_frame", "downloads_never_read",
    "slow_readers", "kept_alive", "slow_body_with_the_token",
}  # fmt: skip


def main(name: str, host: str, port: str, token: str, seconds: str) -> None:
    limit = resource.getrlimit(resource.RLIMIT_NOFILE)[1]
    resource.setrlimit(resource.RLIMIT_NOFILE, (min(4096, limit) if limit > 0 else 4096, limit))
    random.seed(name)
    attack = {**STRANGERS, **MEMBERS}[name]
    attack(Target(host, int(port), token, float(seconds), OTHER if name in MEMBERS else ""))
    os._exit(0)


if __name__ == "__main__":
    main(*sys.argv[1:])
