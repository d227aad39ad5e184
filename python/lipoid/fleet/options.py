"""The options of the command, made from the one declaration of those of identification."""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable
from typing import Any

from lipoid import _core
from lipoid.errors import OptionError

Description = dict[str, Any]
LARGEST_SEED = 2**64 - 1


class Wide(argparse.HelpFormatter):
    """Help as that of ``lipoid``: 100 columns, the names in 28 of them."""

    def __init__(self, prog: str) -> None:
        super().__init__(prog, max_help_position=28, width=100)


def parser(prog: str, what: str, example: str) -> argparse.ArgumentParser:
    """Return a parser that knows no abbreviations."""
    return argparse.ArgumentParser(
        prog=prog,
        description=what,
        epilog=example,
        formatter_class=Wide,
        allow_abbrev=False,
        argument_default=argparse.SUPPRESS,
    )


def _yes(text: str) -> bool:
    if text not in ("true", "false"):
        raise ValueError
    return text == "true"


def _reader(option: Description) -> Callable[[str], Any]:
    kind = option["type"]
    if kind.startswith("float"):
        return float
    if kind.startswith("int"):
        return int
    return _yes if kind == "bool" else str


def _read(name: str, option: Description, text: str) -> Any:
    try:
        return _reader(option)(text)
    except ValueError:
        raise OptionError(f"{name}: expected {option['valid']}, found {text!r}") from None


def _help(option: Description) -> str:
    words = [option["help"]]
    if option["valid"] and option["type"] != "bool":
        words.append(option["valid"])
    text = "; ".join(words)
    if option["default"] not in ("None", "", "false"):
        text += f" (default {option['default']})"
    return text.replace("%", "%%")


def add(to: argparse.ArgumentParser) -> None:
    """Declare every option of identification, with the names of ``lipoid identify``."""
    shown = to.add_argument_group("how a campaign is identified, as lipoid identify")
    groups = []
    for option in _core.describe_identify():
        name = "--" + option["name"].replace("_", "-")
        if "options" in option:
            groups += [f"{_group_name(option)}.{one['name']}" for one in option["options"]]
        elif option["type"] == "bool":
            shown.add_argument(name, action="store_true", help=_help(option))
        elif option["type"].startswith(("Mapping", "str | Sequence")):
            word = "NAME=LOW,HIGH" if "tuple" in option["type"] else "NAME=VALUE"
            if not option["type"].startswith("Mapping"):
                word = "NAME,..."
            shown.add_argument(name, nargs="+", action="extend", metavar=word, help=_help(option))
        else:
            word = "FILE" if _is_file(option) else "VALUE"
            shown.add_argument(name, metavar=word, help=_help(option))
    shown.add_argument(
        "--seed", metavar="VALUE", type=int, help="seed of everything random (default 0)"
    )
    shown.add_argument(
        "--set",
        metavar="OPTION=VALUE",
        nargs="+",
        action="extend",
        help="set one option by its name; lipoid identify --help explains each: "
        + ", ".join(groups),
    )


def _group_name(option: Description) -> str:
    """Return the name on the command line: Python gives that of one group to an option."""
    return str(option["name"]).removesuffix("_fit")


def _pair(name: str, text: str) -> tuple[str, str]:
    key, equals, value = text.partition("=")
    if not equals or not key:
        raise OptionError(f"{name}: expected NAME=VALUE, found {text!r}")
    return key, value


def _mapping(name: str, option: Description, words: list[str]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for word in words:
        key, value = _pair(name, word)
        try:
            numbers = [float(one) for one in value.split(",")]
        except ValueError:
            numbers = []
        wanted = 2 if "tuple" in option["type"] else 1
        if len(numbers) != wanted:
            form = "two numbers with a comma" if wanted == 2 else "a number"
            raise OptionError(f"{name}: expected {form} for {key}, found {value!r}")
        found[key] = tuple(numbers) if wanted == 2 else numbers[0]
    return found


def _names(name: str, words: list[str]) -> list[str]:
    """Return the names of words, each of which may hold several with commas between them."""
    names = [one for word in words for one in word.split(",")]
    if "" in names:
        found = " ".join(words)
        raise OptionError(f"{name}: expected names with a comma between them, found {found!r}")
    return names


def files(given: dict[str, Any]) -> dict[str, str]:
    """Return the files among these keywords of identification, by the option that names them."""
    named = (one["name"] for one in _core.describe_identify() if _is_file(one))
    return {name: given[name] for name in named if os.path.isfile(given.get(name) or "")}


def _is_file(option: Description) -> bool:
    return str(option.get("type", "")).startswith("Path")


def _file_or_shipped(option: Description, text: str) -> str:
    """Return a file by its absolute path, because workers may run elsewhere."""
    is_shipped = "Cell" in option["type"] and text in _core.cell_names()
    return text if is_shipped else os.path.abspath(text)


def keywords(given: argparse.Namespace) -> dict[str, Any]:
    """Return the keywords of :func:`lipoid.identify` that were given, checked.

    Raises
    ------
    OptionError
        For a name or a value that is not allowed.
    """
    found: dict[str, Any] = {}
    groups: dict[str, tuple[str, str, Description]] = {}
    for option in _core.describe_identify():
        name = option["name"]
        shown = "--" + name.replace("_", "-")
        if "options" in option:
            for one in option["options"]:
                groups[f"{_group_name(option)}.{one['name']}"] = (name, one["name"], one)
        elif not hasattr(given, name):
            continue
        elif option["type"].startswith("Mapping"):
            found[name] = _mapping(shown, option, getattr(given, name))
        elif _is_file(option):
            found[name] = _file_or_shipped(option, getattr(given, name))
        elif isinstance(getattr(given, name), list):
            found[name] = _names(shown, getattr(given, name))
        elif isinstance(getattr(given, name), str):
            found[name] = _read(shown, option, getattr(given, name))
        else:
            found[name] = getattr(given, name)
    for word in getattr(given, "set", []):
        key, value = _pair("--set", word)
        if key not in groups:
            raise OptionError(f"--set: unknown option {key!r}. Known: {', '.join(groups)}")
        group, name, one = groups[key]
        found.setdefault(group, {})[name] = _read(key, one, value)
    _core.check_identify(found)
    if hasattr(given, "seed"):
        if not 0 <= given.seed <= LARGEST_SEED:
            raise OptionError(f"--seed: expected 0 .. {LARGEST_SEED}, found {given.seed}")
        found["seed"] = given.seed
    return _without_defaults(found)


def _without_defaults(given: dict[str, Any]) -> dict[str, Any]:
    """Leave out what says only what holds without it: results are told apart by the rest."""
    found = {name: value for name, value in given.items() if (name, value) != ("seed", 0)}
    for option in _core.describe_identify():
        name = option["name"]
        for one in option.get("options", []):
            if found.get(name, {}).get(one["name"]) == _read(name, one, one["default"]):
                found[name] = {key: of for key, of in found[name].items() if key != one["name"]}
        if "options" not in option and option["default"] not in ("None", ""):
            if found.get(name) == _read(name, option, option["default"]):
                del found[name]
        elif found.get(name) == {}:
            del found[name]
    return found
