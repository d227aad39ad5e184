"""Write the two notebooks of this folder, and execute them: python docs/write_notebooks.py

The cells stand here as text, so that a change to them can be read. Needs nbclient and ipykernel; the
tests execute what is committed (tests/python/test_notebooks.py).
"""

from __future__ import annotations

import pathlib
import re
import sys
import tempfile

import nbformat
from nbclient import NotebookClient

FOLDER = pathlib.Path(__file__).resolve().parent

IDENTIFY = [
    """# Identify a cell from its lab logs

A Nissan Leaf pouch cell of 33 Ah: a low-rate discharge, three constant currents and pulses. The logs stand in the checkout
(fixtures/lab); where they do not, the same notebook runs on synthetic logs whose truth is known.""",
    """from pathlib import Path

import lipoid

real = Path("../fixtures/lab/nissan_leaf_33ah/campaign.toml")
campaign = lipoid.Campaign.read(real) if real.exists() else lipoid.synthesize("gifi-600mAh-1", sampling_s=1.0)
campaign""",
    "What is in a log: how it was read, and which stretches of rest and load it has.",
    """log = (campaign.logs("pulses") or campaign.logs())[0]
log""",
    "log.segments.head(8)",
    "One call identifies the cell from all logs. The estimates come with standard errors, and with a verdict on each.",
    "result = lipoid.identify(campaign)\nresult",
    'result.plot("fit");',
    'result.plot("resistances");',
    """What the cell file keeps is enough to draw cells from: how far may a prediction be off?""",
    """import numpy as np

t = np.arange(0.0, 1800.0, 5.0)
i = np.where((t > 60) & (t < 1200), result.cell.capacity_Ah, 0.0)  # 1C
low_V, high_V = result.cell.band(t, i, cells=200)
print(f"95 % of the cells lie within {1e3 * np.max(high_V - low_V):.2f} mV")
result.cell.simulate(t, i).plot();""",
]

COMPARE = [
    """# Compare optimizers, then fly

The same problem for several optimizers, from the same start and from random ones; then a flight on the cell that was found. The
logs are synthetic, so that the truth is known.""",
    """import lipoid

campaign = lipoid.synthesize(
    "gifi-600mAh-1", parameters={"r_1": 0.03, "c_1": 1500.0}, sampling_s=2.0, voltage_noise_V=0.001, seed=1
)
campaign""",
    """comparison = lipoid.compare(campaign, optimizers=["levenberg-marquardt", "sqp", "nelder-mead"], starts=3, seed=1)
comparison.results[["rmse_V", "evaluations", "success_rate", "termination"]]""",
    "comparison.parameters",
    "The joint method fits all logs at once. Its cell flies a square in light gusts.",
    """result = lipoid.identify(campaign)
flight = lipoid.fly("square", cell=result.cell, vehicle="mambo-physical", seed=1, wind={"gusts_m_per_s": 3.0})
flight""",
    "flight.plot();",
    "How well does the cell predict the voltage of that flight, from its current alone?",
    """lipoid.validate(result.cell, flight.log())[["rows", "mean_error_percent", "rmse_V"]]""",
]


def is_code(cell: str) -> bool:
    """Whether the text is a program: prose begins with a capital or a heading, and has no call."""
    try:
        compile(cell, "cell", "exec")
    except SyntaxError:
        return False
    return True


def write(name: str, cells: list[str]) -> None:
    """Make, execute and write one notebook."""
    new = nbformat.v4
    notebook = new.new_notebook(
        cells=[new.new_code_cell(c) if is_code(c) else new.new_markdown_cell(c) for c in cells],
        metadata={
            "kernelspec": {"name": "python3", "display_name": "Python 3", "language": "python"},
            "language_info": {"name": "python"},
        },
    )
    for k, cell in enumerate(notebook.cells):
        cell["id"] = f"cell-{k}"
    NotebookClient(notebook, timeout=600, resources={"metadata": {"path": str(FOLDER)}}).execute()
    for cell in notebook.cells:
        cell.get("metadata", {}).pop("execution", None)
    # Logs that were synthesized lie in a folder of the day.
    text = re.sub(rf"{re.escape(tempfile.gettempdir())}/tmp\w+/", "", nbformat.writes(notebook))
    (FOLDER / name).write_text(text, encoding="utf-8")


def main() -> None:
    """Write both."""
    write("identify-a-cell.ipynb", IDENTIFY)
    write("compare-and-fly.ipynb", COMPARE)


if __name__ == "__main__":
    sys.exit(main())
