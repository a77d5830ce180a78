"""Attacks on the view's server, each a program of sockets: `python -m hostile.network NAME HOST PORT TOKEN SECONDS`.

None of them knows the token. `SILENT` ones hold what they have and send next to nothing.
"""

from __future__ import annotations

import os
import random
import resource
import sys

from .strangers import STRANGERS
from .target import Target

SILENT = {"idle", "of_many_peers", "slow_head"}


def main(name: str, host: str, port: str, token: str, seconds: str) -> None:
    limit = resource.getrlimit(resource.RLIMIT_NOFILE)[1]
    resource.setrlimit(resource.RLIMIT_NOFILE, (min(4096, limit) if limit > 0 else 4096, limit))
    random.seed(name)
    STRANGERS[name](Target(host, int(port), token, float(seconds)))
    os._exit(0)


if __name__ == "__main__":
    main(*sys.argv[1:])
