"""Other programs run the cell: the real packages, where tools/setup --extra installed them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lipoid

T = np.arange(0.0, 900.0, 1.0)
# 1.2 A in pulses of 60 s, 6 of them.
I = np.where((T % 150 >= 60) & (T % 150 < 120), 1.2, 0.0)  # noqa: E741


def constant_cell() -> lipoid.Cell:
    return lipoid.Cell.read("gifi-600mAh-1")


def test_pybamm_has_the_same_voltage() -> None:
    pytest.importorskip("pybamm", reason="tools/setup --extra installs pybamm")
    cell = constant_cell()
    made = cell.to_pybamm()
    ours = cell.simulate(T, I).voltage_V
    theirs = made.run(T, I)
    tenth_of_a_millivolt = 1e-4
    assert np.abs(ours - theirs)[1:].max() < tenth_of_a_millivolt


def test_what_is_no_log_is_refused(tmp_path: Path) -> None:
    no_log: Any = {"time_s": T}
    message = "option mission: expected a Log, as lipoid.read_log makes one of a file, found dict"
    with pytest.raises(lipoid.OptionError, match=message):
        lipoid.export("gifi-600mAh-1", "thevenin", tmp_path / "cell.yaml", mission=no_log)
    with pytest.raises(lipoid.OptionError, match=message):
        constant_cell().to_thevenin(mission=no_log)
    campaign = lipoid.synthesize("gifi-600mAh-1", sampling_s=10.0)
    with pytest.raises(lipoid.OptionError, match="option log: expected a Log, as "):
        campaign.to_pybop("gifi-600mAh-1", log=no_log)


def test_thevenin_takes_the_cell() -> None:
    thevenin = pytest.importorskip("thevenin", reason="tools/setup --extra installs thevenin")
    simulation = constant_cell().to_thevenin()
    assert isinstance(simulation, thevenin.Simulation)
    experiment = thevenin.Experiment()
    experiment.add_step("current_A", 0.6, np.linspace(0.0, 60.0, 61))
    voltage_V = simulation.run(experiment).vars["voltage_V"]
    ours = constant_cell().simulate(np.linspace(0.0, 60.0, 61), np.full(61, 0.6)).voltage_V
    # Two pairs of resistor and capacitor stand for diffusion: 10 mV within a minute.
    assert np.abs(voltage_V - ours)[1:].max() < 0.01


def test_pybop_finds_what_the_logs_were_made_with(campaign: lipoid.Campaign) -> None:
    pytest.importorskip("pybop", reason="tools/setup --extra installs pybop")
    cell = constant_cell()
    v = cell.simulate(T, I).voltage_V
    log = lipoid.Log(time_s=T, current_A=I, voltage_V=v)
    problem = campaign.to_pybop(cell, free=("R0 [Ohm]",), log=log)
    truth = cell.to_dict()["series_resistance_Ohm"]
    costs = [
        float(np.squeeze(problem.evaluate([r]).values)) for r in (0.9 * truth, truth, 1.1 * truth)
    ]
    # PyBOP draws straight lines between rows: a step of the current is a ramp of a second there.
    of_the_ramps = 0.02
    assert costs[1] < of_the_ramps * min(costs[0], costs[2])


@pytest.mark.parametrize("package", ["pybamm", "thevenin", "pybop"])
def test_a_missing_package_is_named_with_its_remedy(
    package: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    import importlib

    def missing(name: str) -> Any:
        raise ModuleNotFoundError(f"No module named {name!r}", name=name)

    monkeypatch.setattr(importlib, "import_module", missing)
    with pytest.raises(ModuleNotFoundError, match=f"pip install {package}"):
        from lipoid import interoperability

        interoperability._imported(package)
