"""The page's head names everything that its program asks for, and nothing else."""

from __future__ import annotations

import re

from twistarm.viewer import Viewer
from viewer_page import arm as arm
from viewer_page import get
from viewer_page import viewer as viewer


def test_every_module_that_the_page_runs_is_named_once_and_served(viewer: Viewer) -> None:
    page = get(viewer.url)[1]
    named = re.findall(r'<link rel="modulepreload" href="([\w.]+)">', page)
    reached, waiting = set(), ["main.js"]
    while waiting:  # as a browser goes from import to import
        name = waiting.pop()
        if name not in reached:
            reached.add(name)
            status, text, headers = get(viewer.url + name)
            assert status == 200, name
            assert headers["Content-Type"].startswith("text/javascript")
            waiting += re.findall(r'\bfrom "\./([\w.]+)"', text)
    assert sorted(named) == sorted(reached)
    assert len(reached) > 30
    assert page.index("modulepreload") < page.index("</head>") < page.index("<body>")


def test_the_schema_is_asked_for_as_the_page_reads_it(viewer: Viewer) -> None:
    assert '<link rel="preload" href="schema.json" as="fetch" crossorigin>' in get(viewer.url)[1]
    assert 'fetch("schema.json")' in get(viewer.url + "main.js")[1]
    assert get(viewer.url + "schema.json")[0] == 200
