"""Progress of long work: by tqdm where it is installed, to a function, or to the log."""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import Any

logger = logging.getLogger("lipoid")
Progress = bool | Callable[[float, str], None]


class Reporter:
    """Hands progress on: to tqdm where it is installed, to a function, to the log."""

    def __init__(self, progress: Progress, what: str) -> None:
        self.callback: Callable[[float, str], None] | None = None
        self.bar: Any = None
        if callable(progress):
            self.callback = progress
        elif progress:
            try:
                from tqdm.auto import tqdm
            except ImportError:
                self.callback = lambda share, stage: logger.info(
                    "%s: %s, %.0f %%", what, stage, 100.0 * share
                )
            else:
                self.bar = tqdm(
                    total=100,
                    desc=what,
                    bar_format="{desc}: {percentage:3.0f}%|{bar}| {elapsed} {postfix}",
                )
                self.callback = self._draw

    def _draw(self, share: float, stage: str) -> None:
        self.bar.set_postfix_str(stage, refresh=False)
        self.bar.n = round(100.0 * share)
        self.bar.refresh()

    def __enter__(self) -> Callable[[float, str], None] | None:
        return self.callback

    def __exit__(self, *_: object) -> None:
        if self.bar is not None:
            self.bar.close()
