"""Campaigns: all the logs of one cell."""

from __future__ import annotations

import os
from collections.abc import Mapping
from html import escape
from typing import TYPE_CHECKING, Any, cast

import pandas as pd

from lipoid import _core, interoperability
from lipoid._cell import Cell, as_cell
from lipoid._keywords import present, takes
from lipoid._log import Log, core_of, listed, of_table, read_log
from lipoid.errors import OptionError

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from lipoid._core import Campaign as CoreCampaign
    from lipoid._options import CampaignOptions
    from lipoid._reading_options import ReadingOptions

KINDS = ("constant_current", "low_rate", "low_rate_charge", "pulses", "flight", "validation")


# What may be said of one log beside how it is read.
_OF_ONE = ("initial_soc", "weight", "ambient_degC", "initial_degC")


def _logs(
    kind: str, several: list[Any], reading: dict[str, Any]
) -> list[tuple[Any, dict[str, Any]]]:
    """Make logs of C++ and paths of what is given for one kind, with what is said of each."""
    from lipoid import readers

    logs: list[tuple[Any, dict[str, Any]]] = []
    for k, one in enumerate(several):
        name = kind if len(several) == 1 else f"{kind}[{k}]"
        said: dict[str, Any] = {}
        if isinstance(one, Mapping) and "file" in one:
            said = {key: value for key, value in one.items() if key != "file"}
            one = one["file"]
        of_one = {key: said.pop(key) for key in _OF_ONE if key in said}
        if isinstance(one, Log):
            log = one._core.named(name) if one.file in ("", "log") else one._core
            logs.append((log, {**said, **of_one}))
        elif not isinstance(one, (str, os.PathLike)):
            if unknown := Log._unknown(said):
                known = ["file", *_OF_ONE, *(one["name"] for one in _core.describe_reading(False))]
                raise OptionError(f"{name}: {_core.unknown_name('option', unknown[0], known)}")
            how = {**of_table(reading, one), **said}
            logs.append((Log(one, name=name, **cast(Any, how))._core, of_one))
        elif readers.is_table(one):
            how = {"most_rows": _core.most_rows_kept, **reading, **said}
            logs.append((read_log(one, **cast(Any, how))._core, of_one))
        else:
            logs.append((os.fspath(one), {**reading, **said, **of_one}))
    return logs


@takes(_core.describe_campaign)
class Campaign:
    """All the logs of one cell, and what is known of the cell.

    Each kind of log is one or several: a :class:`Log`, a path, or a data frame with the columns of
    a log. Paths are read when they are first needed, side by side. A dictionary with any of these
    as ``file`` says more of one log, by the keys of a ``[[log]]`` of a campaign file:
    ``{"file": log, "initial_soc": 0.9, "weight": 2.0, "ambient_degC": 10.0}``, of a path also how
    it is read. A log in memory without a name is called by its kind and place: ``pulses[0]``.

    Parameters
    ----------
    reading : dict, optional
        How files are read: the options of :func:`read_log`. Of a data frame those of :class:`Log`
        hold, too; a :class:`Log` is read already.
    {options}

    Examples
    --------
    >>> import lipoid
    >>> campaign = lipoid.synthesize("gifi-600mAh-1", sampling_s=1.0)
    >>> campaign
    Campaign('gifi-600mAh-1': 6 constant-current, 1 low-rate, 1 pulses, 0.6 Ah, cut-off 3 V)
    """

    _core: CoreCampaign
    _given: Any  # by which it is made anew: options, or its file; paths resolved

    def __init__(
        self, *, reading: ReadingOptions | None = None, **options: Unpack[CampaignOptions]
    ) -> None:
        if not isinstance(reading, Mapping | None):
            raise OptionError(
                f"option reading: expected a dictionary of options of read_log, found {reading!r}"
            )
        how: dict[str, Any] = dict(reading or {})
        _core.check_reading(how)
        given: dict[str, Any] = {key: value for key, value in options.items() if value is not None}
        taken: list[Any] = []
        for kind in KINDS:
            if kind in given:
                several = listed(given[kind])
                taken += several
                given[kind] = _logs(kind, several, how)
        if how and taken and all(isinstance(one, Log) for one in taken):
            raise OptionError(
                f"option reading: {next(iter(how))} is for files and data frames, and every log is "
                "a Log, which is read already; say it where that is made"
            )
        self._core = _core.make_campaign(given, [])
        for kind in KINDS:
            given[kind] = [(_resolved(log), said) for log, said in given.get(kind, ())]
        self._given = given

    @classmethod
    def read(cls, file: str | os.PathLike[str]) -> Campaign:
        """Read a campaign file (TOML), as ``lipoid identify`` takes it.

        Raises
        ------
        LoadError
            With file, line and column, where it is not right; its logs are read when first needed.
        """
        core = _core.read_campaign(present("file", file))
        return cls._of(core, _resolved(os.fsdecode(file)))

    @classmethod
    def _of(cls, core: CoreCampaign, given: dict[str, Any] | str) -> Campaign:
        campaign = cls.__new__(cls)
        campaign._core = core
        campaign._given = given
        return campaign

    @property
    def file(self) -> str:
        """The campaign file; empty where there is none."""
        return self._core.file

    @property
    def _inputs(self) -> list[str]:
        return self._core.inputs

    @property
    def name(self) -> str:
        """The name of the cell."""
        return self._core.name

    @property
    def capacity_Ah(self) -> float | None:
        """Nominal capacity of one cell in Ah."""
        return self._core.capacity_Ah

    @property
    def cutoff_V(self) -> float | None:
        """Voltage of one cell that ends a discharge, in V."""
        return self._core.cutoff_V

    @property
    def series(self) -> int:
        """Cells in series in the logs."""
        return self._core.series

    @property
    def parallel(self) -> int:
        """Cells in parallel in the logs."""
        return self._core.parallel

    @property
    def entries(self) -> pd.DataFrame:
        """The logs as they were given: kind, file, and what is said of each."""
        return pd.DataFrame(self._core.entries(), columns=["kind", "file", *_OF_ONE])

    def logs(self, kind: str | None = None) -> list[Log]:
        """Read the logs, of one kind or all of them, as those of one cell.

        Parameters
        ----------
        kind : str, optional
            "constant_current", "low_rate", "low_rate_charge", "pulses", "flight" or "validation",
            also with dashes, as campaign files write them; not given: all of them.
        """
        asked = None if kind is None else str(kind).replace("-", "_")
        if asked not in (None, *KINDS):
            raise OptionError(f"logs: expected one of {', '.join(KINDS)}, found {kind!r}")
        return [
            Log._of(log)
            for of, log, _ in self._core.logs()
            if asked in (None, of.replace("-", "_"))
        ]

    def to_pybop(
        self,
        cell: Cell | str,
        *,
        free: tuple[str, ...] = ("R0 [Ohm]", "R1 [Ohm]"),
        log: Log | None = None,
        spread: float = 0.5,
    ) -> Any:
        """Make a PyBOP problem: the pulses, PyBaMM's Thevenin model, a sum of squares.

        Parameters
        ----------
        cell : Cell or name
            Where the search begins, and what is held: v_oc(A), capacity, diffusion.
        free : tuple of str
            PyBaMM's names of the parameters that PyBOP shall find; they must be constants.
        log : Log, optional
            What is fitted instead of the first pulse log.
        spread : float
            Standard deviation of PyBOP's prior, as a share of the value.

        Returns
        -------
        pybop.Problem
            To be minimised by any of PyBOP's optimisers.
        """
        fitted = core_of("log", log)
        if fitted is None:
            pulses = self.logs("pulses")
            if not pulses:
                raise OptionError("to_pybop: expected a campaign with pulses, found none")
            fitted = pulses[0]._core
        one = as_cell(cell).pack(1, 1)
        return interoperability.to_pybop(one._core, fitted, free, spread)

    def to_toml(self) -> str:
        """Return the campaign as the text of a campaign file; its logs must be files.

        Names of files are as the campaign has them: where it was read from a file, relative to the
        folder of that.
        """
        return self._core.to_toml()

    def __reduce__(self) -> Any:
        return _remade, (self._given, self._core.text, self._core.sha256)

    def __repr__(self) -> str:
        kinds = self.entries["kind"].value_counts(sort=False)
        parts = [f"{count} {kind}" for kind, count in kinds.items()]
        if self.capacity_Ah is not None:
            parts.append(f"{self.capacity_Ah:g} Ah")
        if self.cutoff_V is not None:
            parts.append(f"cut-off {self.cutoff_V:g} V")
        return f"Campaign({self.name!r}: {', '.join(parts)})"

    def _repr_html_(self) -> str:
        return f"<b>{escape(repr(self))}</b>{self.entries.to_html(index=False)}"


def _resolved(log: Any) -> Any:
    """Return a path that leads to the file from every working folder; a log as it is."""
    return os.path.abspath(log) if isinstance(log, (str, bytes)) else log


def _remade(given: dict[str, Any] | str, text: str, sha256: list[str]) -> Campaign:
    """Make a campaign in another process or folder: its files are read when they are needed."""
    if isinstance(given, str):
        return Campaign._of(_core.parse_campaign(text, given, sha256), given)
    return Campaign._of(_core.make_campaign(given, sha256), given)


def as_campaign(campaign: Campaign | str | os.PathLike[str]) -> Campaign:
    """Return a campaign, or read the one of that file."""
    if isinstance(campaign, Campaign):
        return campaign
    if not isinstance(campaign, (str, os.PathLike)):
        raise TypeError(
            "expected a Campaign or the path of a campaign file, found "
            f"{type(campaign).__name__}; logs make one: lipoid.Campaign(pulses=log, cutoff_V=3.0)"
        )
    return Campaign.read(campaign)
