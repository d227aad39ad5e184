"""Files that appear whole or not at all."""

from __future__ import annotations

import contextlib
import os
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

from lipoid.fleet.errors import UsageError

STANDARD_OUTPUT = ("-", "/dev/stdout", "/dev/fd/1", "/proc/self/fd/1")


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


def check_writable(file: str, own: Callable[[bytes], bool] | None = None) -> None:
    """Refuse, before any work, what could not be written or would be lost.

    Parameters
    ----------
    file : str
        To be written at the end.
    own : callable, optional
        Whether a file that is there and begins so may be replaced; none: any may.

    Raises
    ------
    UsageError
        For a device or a pipe, a folder that is not there, and a file of another kind.
    """
    target = Path(os.path.realpath(file))
    if target.exists() and not target.is_file():
        raise UsageError(f"{file}: expected a file to write, found a folder, a device or a pipe")
    if not target.parent.is_dir():
        raise UsageError(f"{file}: cannot be written: there is no folder {target.parent}")
    if own and target.exists() and target.stat().st_size:
        with target.open("rb") as there:
            if not own(there.read(1 << 20)):
                raise UsageError(f"{file} is there and holds something else; give another name")


def write_text(file: str, text: str) -> None:
    """Write a file of text, or print it where the file is "-"."""
    if file in STANDARD_OUTPUT:
        print(text, end="")
        return
    with appears_whole(file) as temporary:
        Path(temporary).write_text(text, encoding="utf-8", errors="surrogateescape")
