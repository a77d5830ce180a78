"""Values that have no business in a description, each a trouble seen or feared; short ones stand in hostile.json."""

import json
from pathlib import Path

_VALUES: dict[str, list[str]] = json.loads((Path(__file__).parent / "hostile.json").read_text("utf-8"))

NUMBERS = (*_VALUES["numbers"], "9" * 400, "0." + "3" * 400)
VECTORS = tuple(_VALUES["vectors"])
NAMES = (*_VALUES["names"], "n" * 300, "n" * 5000, "\u00e4" * 3000)
EXPRESSIONS = (*_VALUES["expressions"], "${" + "(" * 300 + ")" * 300 + "}", "${" + "-" * 5000 + "1}")
ELEMENTS = tuple(_VALUES["elements"])
DOCUMENT_TYPES = tuple(_VALUES["document types"])
ENTITIES = tuple(_VALUES["entities"])
JOINT_TYPES = tuple(_VALUES["joint types"])
TAGS = tuple(_VALUES["tags"])
TABLE_VALUES = (*_VALUES["table values"], "9" * 400)
