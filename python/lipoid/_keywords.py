"""Signatures and docstrings made from what C++ says of its options."""

from __future__ import annotations

import inspect
import textwrap
from collections.abc import Callable
from operator import index
from typing import Any, TypeVar

import numpy as np

from lipoid.errors import OptionError

Function = TypeVar("Function", bound=Callable[..., Any])
_T = TypeVar("_T")
Description = dict[str, Any]


def whole(name: str, value: Any, *, least: int = 0, most: int = 2**31 - 1) -> int:
    """Return a whole number within these limits, of whatever type it is, or say that it is none."""
    try:
        number = least - 1 if isinstance(value, (bool, np.bool_)) else index(value)
    except TypeError:
        number = least - 1
    if not least <= number <= most:
        bound = f"most {most}" if number > most else f"least {least}"
        raise OptionError(f"option {name}: expected a whole number of at {bound}, found {value!r}")
    return number


def present(name: str, value: _T, wanted: str = "a path") -> _T:
    """Return what was given for an argument, or say that it is missing."""
    if value is None:
        raise TypeError(f"{name}: expected {wanted}, found None")
    return value


def utf8(name: str, value: Any) -> str:
    """Return a text of UTF-8, or say that it is none: names of files are texts that may not be."""
    made = str(value)
    try:
        made.encode()
    except UnicodeEncodeError:
        found = ascii(made)
        raise OptionError(f"option {name}: expected text of UTF-8, found {found}") from None
    return made


def whole_seed(value: Any) -> int:
    """Return a seed, which may be any number of 64 bits."""
    return whole("seed", value, most=2**64 - 1)


def _default(option: Description) -> str:
    text = str(option["default"])
    if option["type"].startswith(("Literal", "str")):
        return f'"{text}"'
    return {"true": "True", "false": "False", "": '""'}.get(text, text)


def _paragraph(option: Description, indent: str) -> str:
    valid = option["valid"]
    numbers = valid if valid and not option["type"].startswith(("Literal", "bool")) else ""
    words = str(option["help"]).removesuffix("...").rstrip(", ")
    if "_" not in words.split()[0]:  # no symbol, as v_oc(A)
        words = words[0].upper() + words[1:]
    words += f" (valid: {numbers})." if numbers and numbers not in ("text", "numbers") else "."
    head = f"{indent}{option['name']} : {option['type']}"
    if not option["type"].endswith("None"):
        head += f", default {_default(option)}"
    text = textwrap.fill(
        words, 92, initial_indent=indent + "    ", subsequent_indent=indent + "    "
    )
    return f"{head}\n{text}"


def describe(options: list[Description], indent: str = "") -> str:
    """Every option as a numpydoc paragraph, groups as dictionaries."""
    parts = []
    for option in options:
        if "options" not in option:
            parts.append(_paragraph(option, indent))
            continue
        names = ", ".join(one["name"] for one in option["options"])
        head = f"{indent}{option['name']} : dict, optional"
        keys = textwrap.fill(
            f"Keys: {names}.",
            92,
            initial_indent=indent + "    ",
            subsequent_indent=indent + "    ",
        )
        inner = describe(option["options"], indent + "    ")
        parts.append(f"{head}\n{keys}\n\n{inner}")
    return "\n".join(parts)


def takes(*described: Callable[[], list[Description]]) -> Callable[[Function], Function]:
    """Put the options that C++ describes into the signature and the docstring of a function.

    The docstring has a line ``{options}`` where they go; the function takes them by ``**options``.
    """

    def decorate(function: Function) -> Function:
        options = [option for describe_it in described for option in describe_it()]
        signature = inspect.signature(function)  # of a class: that of its __init__
        kept = [
            parameter
            for parameter in signature.parameters.values()
            if parameter.kind is not inspect.Parameter.VAR_KEYWORD
        ]
        named = {parameter.name for parameter in kept}
        kept += [
            inspect.Parameter(option["name"], inspect.Parameter.KEYWORD_ONLY, default=None)
            for option in options
            if option["name"] not in named
        ]
        function.__signature__ = signature.replace(parameters=kept)  # type: ignore[attr-defined]
        shown = [option for option in options if option["name"] not in named]
        # Since Python 3.13 the compiler takes the indent away, as cleandoc does.
        document = inspect.cleandoc(function.__doc__ or "")
        function.__doc__ = document.replace("{options}\n", describe(shown) + "\n")
        return function

    return decorate
