"""Results as pages: what stands in the page is what Python has."""

import base64
import json
import re
from pathlib import Path
from typing import Any, cast

import numpy as np
import numpy.typing as npt
import pytest

import lipoid
from conftest import ROOT
from lipoid import _core

FloatArray = npt.NDArray[Any]

pytestmark = pytest.mark.skipif(
    not _core.can_report(), reason="built without reports, which need npm"
)


def data_of(page: Path) -> dict[str, Any]:
    text = page.read_text(encoding="utf-8")
    found = re.search(r'<script type="application/json" id="data">(.*?)</script>', text, re.S)
    assert found is not None
    return cast("dict[str, Any]", json.loads(found[1]))


def column(series: dict[str, Any], name: str) -> FloatArray:
    one = next(c for c in series["columns"] if c["name"] == name)
    if one["type"] == "copy":
        return column(series, one["of"])
    if one["type"] == "constant":
        return np.full(one["length"], one["value"], dtype=float)
    kind = np.float64 if one["type"] == "f64" else np.float32
    return np.frombuffer(base64.b64decode(one["data"]), dtype=kind)


@pytest.fixture(scope="module")
def result() -> lipoid.Identification:
    return lipoid.identify(lipoid.synthesize("gifi-600mAh-1", sampling_s=2.0), method="joint")


def test_page_of_an_identification_shows_its_numbers_and_logs(
    result: lipoid.Identification, tmp_path: Path
) -> None:
    result.report(tmp_path / "cell.html")
    (shown,) = data_of(tmp_path / "cell.html")["results"]
    assert shown["summary"]["command"] == "identify"
    assert shown["summary"]["fit"] == result.summary["fit"]
    logs = [s for s in shown["series"] if s["kind"] == "log"]
    assert [s["rows"] for s in logs] == [len(log) for _, log, _ in result.campaign._core.logs()]
    # The page's prediction is that of the cell itself, at single precision.
    first = max(logs, key=lambda s: s["rows"])
    of = next(log for _, log, _ in result.campaign._core.logs() if len(log) == first["rows"])
    whole = result.cell.simulate(np.asarray(of.time_s), np.asarray(of.current_A), hold=of.hold)
    at = np.searchsorted(of.time_s, column(first, "time_s"))
    assert np.allclose(column(first, "predicted_V"), whole.voltage_V[at], atol=2e-6)
    assert "staged_V" in [c["name"] for c in first["columns"]]


def test_page_of_several_results_holds_each(result: lipoid.Identification, tmp_path: Path) -> None:
    flight = lipoid.fly("hover", duration=3.0)
    lipoid.report([result, flight], tmp_path / "both.html")
    results = data_of(tmp_path / "both.html")["results"]
    assert [r["summary"]["command"] for r in results] == ["identify", "fly"]
    (series,) = results[1]["series"]
    assert series["kind"] == "flight"
    assert np.allclose(column(series, "battery_V"), flight.data["battery_V"].to_numpy(), rtol=1e-6)


def test_page_of_a_comparison(tmp_path: Path) -> None:
    campaign = lipoid.synthesize("gifi-600mAh-1", sampling_s=5.0)
    found = lipoid.compare(campaign, optimizers=["levenberg-marquardt", "sqp"])
    found.report(tmp_path / "compare.html")
    (shown,) = data_of(tmp_path / "compare.html")["results"]
    assert shown["summary"]["best"] == found.summary["best"]
    assert "2 optimizers" in repr(found)


def test_pages_of_an_endurance_and_a_health(tmp_path: Path) -> None:
    flown = lipoid.endurance("grepow-32Ah-1", vehicle="f450", series=4, capacity_Ah=5.0)
    flown.report(tmp_path / "endurance.html")
    aged = lipoid.health(
        "gifi-600mAh-1", ROOT / "fixtures/flights/log171.bin", capacity_Ah=5.2, series=4
    )
    lipoid.report([aged, flown], tmp_path / "both.html")
    results = data_of(tmp_path / "both.html")["results"]
    assert [one["summary"]["command"] for one in results] == ["health", "endurance"]
    assert results[1]["summary"]["minutes"] == flown.minutes


def test_what_has_no_page_here_says_where_it_has(tmp_path: Path) -> None:
    table: Any = lipoid.plan("gifi-600mAh-1")
    for wrong in (table, [table]):
        with pytest.raises(TypeError, match="or Health, or several, found DataFrame; of study"):
            lipoid.report(wrong, tmp_path / "page.html")


def test_a_page_that_cannot_be_written_says_so(
    result: lipoid.Identification, tmp_path: Path
) -> None:
    with pytest.raises(lipoid.OptionError, match="cannot write"):
        result.report(tmp_path / "no" / "folder" / "cell.html")
