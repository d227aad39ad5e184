"""Write lipoid/_options.py: the types of all options, from what C++ says of them.

``python -m lipoid._write_options`` prints it; a test holds the committed file to that.
"""

from __future__ import annotations

from lipoid import _core
from lipoid._keywords import Description

FUNCTIONS = {
    "ReadingOptions": lambda: _core.describe_reading(True),
    "ColumnOptions": lambda: _core.describe_reading(False),
    "CampaignOptions": _core.describe_campaign,
    "IdentifyOptions": _core.describe_identify,
    "CompareOptions": _core.describe_compare,
    "StudyOptions": _core.describe_study,
    "PlanOptions": _core.describe_plan,
    "SynthesizeOptions": _core.describe_synthesize,
    "FlyOptions": _core.describe_fly,
    "EnduranceOptions": _core.describe_endurance,
    "HealthOptions": _core.describe_health,
    "ExportOptions": _core.describe_export,
}

HEAD = '''"""The options of every function, as types.

Made by ``python -m lipoid._write_options`` from the one declaration that the command line and the
docstrings are made from, too: do not edit.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, TypedDict

if TYPE_CHECKING:
    from lipoid._cell import Cell
    from lipoid._log import Log

Path: TypeAlias = str | os.PathLike[str]
Logs: TypeAlias = "Sequence[Log | Path] | Log | Path | Mapping[str, Any]"

'''


def _class_name(function: str, group: str) -> str:
    return function.removesuffix("Options") + "".join(w.title() for w in group.split("_")) + "Group"


def _fields(options: list[Description], function: str) -> list[str]:
    lines = []
    for option in options:
        name = option["name"]
        if "options" in option:
            lines.append(f"    {name}: {_class_name(function, name)}")
            continue
        lines.append(f"    {name}: {option['type']}")
    return lines


def text() -> str:
    """Return the whole file."""
    parts = [HEAD]
    for function, describe in FUNCTIONS.items():
        options = describe()
        for option in options:
            if "options" in option:
                name = _class_name(function, option["name"])
                parts.append(f"class {name}(TypedDict, total=False):")
                parts.append(f'    """Keys of ``{option["name"]}``."""\n')
                parts.append("\n".join(_fields(option["options"], function)) + "\n\n")
        parts.append(f"class {function}(TypedDict, total=False):")
        parts.append('    """Keyword arguments."""\n')
        parts.append("\n".join(_fields(options, function)) + "\n\n")
    return "\n".join(parts).rstrip() + "\n"


if __name__ == "__main__":
    print(text(), end="")
