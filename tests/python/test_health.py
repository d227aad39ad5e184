"""Health of packs by flights, and flights alone: the numbers of the command line."""

from __future__ import annotations

from pathlib import Path

import pytest

import lipoid
from conftest import ROOT, Lipoid

SOLO = ROOT / "fixtures/flights/log171.bin"


def test_a_health_is_that_of_the_program(program: Lipoid, tmp_path: Path) -> None:
    theirs = program(
        "health",
        "--cell",
        "gifi-600mAh-1",
        "--capacity-Ah",
        5.2,
        "--series",
        4,
        SOLO,
        folder=tmp_path,
    )
    made = lipoid.health("gifi-600mAh-1", SOLO, capacity_Ah=5.2, series=4)
    ours, of_program = dict(made.summary["flights"][0]), dict(theirs["flights"][0])
    assert ours == of_program
    assert made.flights.loc[0, "soc_start"] == ours["soc_start"]
    assert made.sentence in repr(made)


def test_a_health_reads_its_flights_as_the_program_does() -> None:
    two = ROOT / "fixtures/flights/sample_log_small.ulg"
    with pytest.raises(lipoid.LoadError, match=r"battery=1"):
        lipoid.health("gifi-600mAh-1", two, series=6)
    with pytest.raises(lipoid.LoadError, match=r"at least 20 s"):
        lipoid.health("gifi-600mAh-1", two, series=6, battery=1)


def test_a_health_needs_a_flight() -> None:
    with pytest.raises(
        lipoid.OptionError, match="health: expected at least one flight, found none"
    ):
        lipoid.health("gifi-600mAh-1", [])


def test_a_pack_that_no_log_names_is_asked_for() -> None:
    with pytest.raises(lipoid.OptionError, match="give series=4"):
        lipoid.health("gifi-600mAh-1", SOLO)


def test_flights_alone_are_identified_as_by_the_program(program: Lipoid, tmp_path: Path) -> None:
    theirs = program(
        "identify",
        "--flight",
        SOLO,
        "--series",
        4,
        "--capacity-Ah",
        5.2,
        "--initial-soc",
        0.93,
        "-o",
        "cell.json",
        folder=tmp_path,
    )
    flown = lipoid.Campaign(flight=[SOLO], series=4, capacity_Ah=5.2, initial_soc=0.93)
    made = lipoid.identify(flown)
    assert made.summary["parameters"] == theirs["parameters"]
    assert made.summary["fit"] == theirs["fit"]
