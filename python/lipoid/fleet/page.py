"""The report of a fleet as one page that runs no script, loads nothing, and opens from disk."""

from __future__ import annotations

import base64
import hashlib
from html import escape

import numpy as np
import pandas as pd

from lipoid.fleet.spread import BINS, Quantity

MOST_OUTLIERS = 200

STYLE = """
:root { color-scheme: light dark; }
body { font: 15px/1.45 system-ui, sans-serif; margin: 2rem auto; max-width: 72rem;
  padding: 0 1rem; }
h1 { font-size: 1.5rem; } h2 { font-size: 1.2rem; margin-top: 2.2rem; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; }
th, td { padding: .2rem .7rem; text-align: right; border-bottom: 1px solid #8884; }
th:first-child, td:first-child, td.text { text-align: left; }
thead th { position: sticky; top: 0; background: Canvas; }
.wide { overflow-x: auto; }
.charts { display: flex; flex-wrap: wrap; gap: 1rem; }
figure { margin: 0; } figcaption { font-size: .85rem; }
svg { display: block; } svg text { font: 10px system-ui, sans-serif; fill: currentColor; }
.bar { fill: #3b7dd8; } .line { stroke: currentColor; stroke-width: 1; fill: none; }
.range { stroke: #3b7dd8; stroke-width: 2; } .point { fill: #3b7dd8; } .far { fill: #d8533b; }
.found { font-weight: 600; }
@media print { thead th { position: static; } }
"""

WIDTH, HEIGHT, MARGIN = 330, 130, 18


def number(value: object) -> str:
    """Return a number for a table; what is not there is a dash."""
    if isinstance(value, (bool, np.bool_)):
        return "yes" if value else "no"
    if isinstance(value, (int, np.integer)):
        return str(value)
    if isinstance(value, float):
        return f"{value:.4g}" if np.isfinite(value) else "-"
    return escape("-" if value is None else str(value))


def table(rows: pd.DataFrame, titles: dict[str, str]) -> str:
    """Return a table of these columns."""
    head = "".join(f"<th>{escape(title)}</th>" for title in titles.values())
    body = []
    for row in rows[list(titles)].itertuples(index=False, name=None):
        cells = "".join(
            f'<td class="text">{number(one)}</td>'
            if isinstance(one, str)
            else f"<td>{number(one)}</td>"
            for one in row
        )
        body.append(f"<tr>{cells}</tr>")
    return (
        f'<div class="wide"><table><thead><tr>{head}</tr></thead>'
        f"<tbody>{''.join(body)}</tbody></table></div>"
    )


def _figure(drawn: str, caption: str, height: int = HEIGHT) -> str:
    return (
        f'<figure><svg width="{WIDTH}" height="{height}" role="img" aria-label="{escape(caption)}">'
        f"{drawn}</svg><figcaption>{escape(caption)}</figcaption></figure>"
    )


def histogram(one: Quantity, sigmas: float) -> str:
    """Draw how often values occur; bars with cells that stand out are red."""
    values = one.values["value"].to_numpy()
    low, high = float(values.min()), float(values.max())
    if one.width > 0.0:  # odd cells must not squeeze the others into one bar
        low = max(low, one.center - 1.5 * sigmas * one.width)
        high = min(high, one.center + 1.5 * sigmas * one.width)
    if not high > low:
        low, high = low - 0.5 * abs(low) - 1e-12, high + 0.5 * abs(high) + 1e-12
    counts, _ = np.histogram(np.clip(values, low, high), BINS, (low, high))
    outliers = one.outliers(sigmas)["value"].to_numpy()
    far, _ = np.histogram(np.clip(outliers, low, high), BINS, (low, high))
    bar = (WIDTH - 2 * MARGIN) / BINS
    foot = HEIGHT - MARGIN
    drawn = []
    for k, count in enumerate(counts):
        if not count:
            continue
        tall = max(1.0, (foot - 8.0) * count / counts.max())
        drawn.append(
            f'<rect class="{"far" if far[k] else "bar"}" x="{MARGIN + k * bar:.1f}" '
            f'y="{foot - tall:.1f}" width="{max(bar - 1, 1):.1f}" height="{tall:.1f}"/>'
        )
    drawn.append(f'<path class="line" d="M{MARGIN} {foot}H{WIDTH - MARGIN}"/>')
    for value, x, anchor in ((low, MARGIN, "start"), (high, WIDTH - MARGIN, "end")):
        drawn.append(f'<text x="{x}" y="{HEIGHT - 5}" text-anchor="{anchor}">{value:.4g}</text>')
    return _figure("".join(drawn), f"{one.name} in {one.unit or 1}: {one.identified} cells")


def ranges(title: str, rows: list[tuple[str, float, float, float]]) -> str:
    """Draw a median and the range of 90 % of the cells for each batch or age."""
    low = min(row[1] for row in rows)
    high = max(row[3] for row in rows)
    scale = (WIDTH - 130) / (high - low) if high > low else 0.0
    drawn = []
    for k, (label, least, middle, most) in enumerate(rows):
        y = 14 + 15 * k
        begin, point, end = (115 + scale * (value - low) for value in (least, middle, most))
        short = label if len(label) <= 18 else f"{label[:17]}…"
        drawn.append(
            f'<text x="105" y="{y + 3}" text-anchor="end">{escape(short)}</text>'
            f'<path class="range" d="M{begin:.1f} {y}H{end + 0.1:.1f}"/>'
            f'<circle class="point" cx="{point:.1f}" cy="{y}" r="3.5"/>'
        )
    height = 14 + 15 * len(rows) + 18
    for value, x, anchor in ((low, 115, "start"), (high, WIDTH - 15, "end")):
        drawn.append(f'<text x="{x}" y="{height - 5}" text-anchor="{anchor}">{value:.4g}</text>')
    return _figure("".join(drawn), title, height)


def page(title: str, parts: list[str]) -> str:
    """Return the whole page."""
    digest = base64.b64encode(hashlib.sha256(STYLE.encode()).digest()).decode()
    policy = f"default-src 'none'; style-src 'sha256-{digest}'; base-uri 'none'; form-action 'none'"
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'<meta http-equiv="Content-Security-Policy" content="{policy}">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{escape(title)}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n"
        f"<h1>{escape(title)}</h1>\n" + "\n".join(parts) + "\n</body>\n</html>\n"
    )
