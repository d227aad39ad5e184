"""Particle swarm with the thesis' settings on the thesis-scale pulses, against the best cost."""

import json

from .process import BenchError, run, say

OPTIMIZERS = ["levenberg-marquardt", "particle-swarm"]


def measure(settings):
    summary_file = settings.scratch / "compare.summary.json"
    summary_file.unlink(missing_ok=True)
    if run([settings.lipoid, "compare", "--help"], expect_success=False).exit_code != 0:
        return {"skipped": "this lipoid has no command `compare`"}
    say("optimizers: " + ", ".join(OPTIMIZERS))
    ended = run([settings.lipoid, "compare", settings.campaign / "campaign.toml", "--optimizers",
                 ",".join(OPTIMIZERS), "--summary", summary_file, "--quiet"], expect_success=False)
    summary = json.loads(summary_file.read_text(encoding="utf-8")) if summary_file.is_file() else {}
    if "results" not in summary:
        raise BenchError(f"{ended.command} ended with {ended.exit_code}:\n{ended.err[-2000:]}")
    results = summary["results"]
    best = min(row["rmse_V"] for row in results)
    rows = []
    for row in results:
        rows.append({key: row.get(key) for key in (
            "optimizer", "rmse_V", "wall_s", "evaluations", "gradient_evaluations", "termination")})
        rows[-1]["cost_above_best_percent"] = 100.0 * ((row["rmse_V"] / best) ** 2 - 1.0)
    return {"command": ended.command, "exit_code": ended.exit_code, **ended.figures(), "rows": rows}
