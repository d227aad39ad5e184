"""What the tests share: the program, synthetic logs of a cell that is known."""

from __future__ import annotations

import json
import os
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib
import pytest

import lipoid

matplotlib.use("Agg")

ROOT = Path(__file__).resolve().parents[2]
Lipoid = Callable[..., dict[str, Any]]
# Of the program, which is not built for the sanitizer that tools/thread-check --python preloads.
PLAIN = {key: value for key, value in os.environ.items() if key != "LD_PRELOAD"}


@pytest.fixture(scope="session")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The lab's logs of a 600 mAh cell whose truth is known, with 1 mV of noise, as files."""
    folder = tmp_path_factory.mktemp("lab")
    lipoid.synthesize(
        "gifi-600mAh-1",
        folder / "logs",
        parameters={"r_1": 0.03, "c_1": 1500.0},
        seed=1,
        sampling_s=1.0,
        voltage_noise_V=0.001,
        rates_C="1,3,6",
    )
    return folder / "logs"


@pytest.fixture(scope="session")
def campaign(lab: Path) -> lipoid.Campaign:
    return lipoid.Campaign.read(lab / "campaign.toml")


@pytest.fixture(scope="session")
def result(campaign: lipoid.Campaign) -> lipoid.Identification:
    return lipoid.identify(campaign, profile=["beta"])


@pytest.fixture(scope="session")
def staged(campaign: lipoid.Campaign) -> lipoid.Identification:
    return lipoid.identify(campaign, method="staged")


@pytest.fixture(scope="session")
def program() -> Lipoid:
    """Run the command line, the independent way to the same numbers; return its --summary."""
    path = os.environ.get("LIPOID_PROGRAM", str(ROOT / "build/dev/tools/lipoid"))
    if not Path(path).exists():
        pytest.skip("the program is not built: LIPOID_PROGRAM names it")

    def run(*arguments: object, folder: Path) -> dict[str, Any]:
        summary = folder / "summary.json"
        command = [path, *map(str, arguments), "--summary", str(summary), "--quiet"]
        subprocess.run(command, cwd=folder, env=PLAIN, check=False, capture_output=True)
        read: dict[str, Any] = json.loads(summary.read_text())
        return read

    return run
