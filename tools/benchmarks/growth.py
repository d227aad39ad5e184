"""How time grows with rows, branches and terms."""

from . import google
from .process import say

SERIES = {
    "sweep": ("GrowthRows/sweep/", "rows", "one sweep with its Jacobian"),
    "prepare": ("GrowthRows/prepare/", "rows", "what is prepared once before the sweeps"),
    "fit": ("GrowthRows/fit/", "rows", "the whole fit (4.61), from the record to the errors"),
    "stream": ("GrowthRows/stream/", "rows", "prediction row by row, nothing kept"),
    "branches": ("GrowthBranches/", "branches", "one sweep with its Jacobian"),
    "terms": ("GrowthTerms/", "terms", "one sweep with its Jacobian"),
}


def measure(settings):
    say(f"growth, up to {settings.growth_rows:.0e} rows")
    command, rows = google.measure(settings, "Growth", f"--growth-rows={settings.growth_rows:.0e}")
    result = {"command": command, "series": {}}
    for key, (prefix, unit, what) in SERIES.items():
        points = []
        for row in rows:
            if not row["name"].startswith(prefix):
                continue
            points.append({
                unit: int(row["name"][len(prefix):].split("/")[0]),
                "wall_s": row["real_s"],
                "rows_per_s": row["items_per_second"],
            })
        result["series"][key] = {"what": what, "unit": unit, "points": points}
    result["series"]["branches"]["rows"] = result["series"]["terms"]["rows"] = \
        min(1_000_000, int(settings.growth_rows))
    return result
