"""Write the types of all options, from what C++ says of them.

``python -m lipoid._write_options`` writes ``_reading_options.py`` and ``_options.py`` beside this
file; a test holds the committed files to that. They are two because a log needs the first, and the
second needs logs and cells.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from lipoid import _core
from lipoid._health import describe_health
from lipoid._keywords import Description

READING = {
    "ReadingOptions": lambda: _core.describe_reading(True),
    "ColumnOptions": lambda: _core.describe_reading(False),
}
FUNCTIONS = {
    "CampaignOptions": _core.describe_campaign,
    "IdentifyOptions": _core.describe_identify,
    "CompareOptions": _core.describe_compare,
    "StudyOptions": _core.describe_study,
    "PlanOptions": _core.describe_plan,
    "SynthesizeOptions": _core.describe_synthesize,
    "FlyOptions": _core.describe_fly,
    "EnduranceOptions": _core.describe_endurance,
    "HealthOptions": describe_health,
    "ExportOptions": _core.describe_export,
}

MADE = """\
Made by ``python -m lipoid._write_options`` from the one declaration that the command line and the
docstrings are made from, too: do not edit."""

READING_HEAD = f'''"""The options of reading logs, as types.

{MADE}
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Literal, TypedDict

'''

HEAD = f'''"""The options of every function but those that read logs, as types.

{MADE}
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, TypedDict

if TYPE_CHECKING:
    from lipoid._cell import Cell
    from lipoid._log import Log, Logs

Path: TypeAlias = str | os.PathLike[str]

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


def _text(head: str, functions: dict[str, Callable[[], list[Description]]]) -> str:
    parts = [head]
    for function, describe in functions.items():
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


def files() -> dict[Path, str]:
    """Return what each file has to hold."""
    folder = Path(__file__).resolve().parent
    return {
        folder / "_reading_options.py": _text(READING_HEAD, READING),
        folder / "_options.py": _text(HEAD, FUNCTIONS),
    }


if __name__ == "__main__":
    for path, text in files().items():
        path.write_text(text, encoding="utf-8")
