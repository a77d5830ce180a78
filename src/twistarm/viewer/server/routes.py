"""Routes of the web server: addresses and their handlers."""

from __future__ import annotations

import re

import tornado.web

from ...support.strict_json import LARGEST_MESSAGE
from ..page_files import page_files
from .downloads import DOWNLOADS
from .handlers import DownloadHandler, PageHandler, Service, SocketHandler
from .preloading import with_preloads

PING_TIME = 20
"""Seconds between two signs of life that a page is asked for, and until one that gives none is let go."""


def application(server: Service) -> tornado.web.Application:
    """Everything stands under the token, which the gateway has seen."""
    shared, files = {"server": server}, page_files()
    files[""] = (files[""][0], with_preloads(files[""][1]))
    return tornado.web.Application(
        [
            (r"/([^/]*)/socket", SocketHandler, shared),
            (rf"/([^/]*)/({'|'.join(map(re.escape, DOWNLOADS))})", DownloadHandler, shared),
            (r"/([^/]*)/?(.*)", PageHandler, {"files": files}),
        ],
        log_function=lambda handler: None,
        websocket_max_message_size=LARGEST_MESSAGE,
        websocket_ping_interval=PING_TIME,
        websocket_ping_timeout=PING_TIME,
    )
