"""Files that appear whole or not at all."""

from __future__ import annotations

import contextlib
import os
import tempfile
from collections.abc import Iterator
from pathlib import Path

from lipoid.fleet.errors import UsageError


@contextlib.contextmanager
def appears_whole(file: str) -> Iterator[str]:
    """Yield the name of a temporary beside the file; it takes the file's name at the end."""
    target = Path(os.path.realpath(file))
    if target.is_dir():
        raise UsageError(f"{file}: expected a file to write, found a folder")
    try:
        number, temporary = tempfile.mkstemp(".tmp", f".lipoid-{target.name}-", target.parent)
    except OSError as error:
        raise UsageError(f"{file}: cannot be written: {error.strerror}") from None
    os.close(number)
    try:
        yield temporary
        mask = os.umask(0)
        os.umask(mask)
        mode = target.stat().st_mode & 0o7777 if target.exists() else 0o666 & ~mask
        os.chmod(temporary, mode)
        with open(temporary, "rb") as written:
            os.fsync(written.fileno())
        os.replace(temporary, target)
    except OSError as error:
        raise UsageError(f"{file}: cannot be written: {error.strerror or error}") from None
    finally:
        Path(temporary).unlink(missing_ok=True)


def write_text(file: str, text: str) -> None:
    """Write a file of text, or print it where the file is "-"."""
    if file == "-":
        print(text, end="")
        return
    with appears_whole(file) as temporary:
        Path(temporary).write_text(text, encoding="utf-8", errors="surrogateescape")
