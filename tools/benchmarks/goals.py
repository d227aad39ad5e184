"""The goals, and whether the figures meet them. A goal without its figure is open, not met."""

from .joint import COMPARABLE, GOALS_S

PEER_DIGITS_V = 5e-7  # the peer prints its rmse with six decimals


def judge(result):
    """[{"goal", "wanted", "found", "met"}]; met is None where something was not measured."""
    return [
        whole_run(result),
        joint_fit(result),
        particle_swarm(result),
        csv_reading(result),
        peak_memory(result),
        field_tool(result),
        *joint_method(result),
    ]


def row(goal, wanted, found=None, met=None):
    return {"goal": goal, "wanted": wanted, "found": found, "met": met}


def staged(result):
    stage = result["stages"].get("staged", {})
    return stage.get("lipoid", {}).get("median"), stage.get("peer", {}).get("median")


def whole_run(result):
    texts = ("whole staged run, CSV on disk to cell file",
             "250 times faster than the SciPy peer, at no larger rmse")
    ours, theirs = staged(result)
    if not ours or not theirs:
        return row(*texts)
    ratio = theirs["total_s"] / ours["wall_s"]
    found = (f"{ratio:.0f} times; rmse {1e3 * ours['rmse_V']:.4f} mV, "
             f"peer {1e3 * theirs['rmse_V']:.3f} mV")
    no_larger = ours["rmse_V"] <= theirs["rmse_V"] + PEER_DIGITS_V
    return row(*texts, found, ratio >= 250 and no_larger)


def joint_fit(result):
    texts = ("the joint fit (4.61) alone", "1,000 times faster than the peer's fit; rmse by "
             "`validate` equal to 1e-9 V")
    ours, theirs = staged(result)
    if not ours or not theirs:
        return row(*texts)
    ratio = theirs["fit_s"] / ours["joint_fit_s"]
    difference_V = result["stages"]["staged"]["validation"]["difference_V"]
    return row(*texts, f"{ratio:.0f} times; rmse differs by {difference_V:.1e} V", ratio >= 1000)


def particle_swarm(result):
    texts = ("particle swarm with the thesis' settings",
             "under 10 s, cost within 0.1 % of the best")
    for line in result["stages"].get("optimizers", {}).get("rows", []):
        if line["optimizer"] != "particle-swarm":
            continue
        above = line["cost_above_best_percent"]
        return row(*texts, f"{line['wall_s']:.2f} s, {above:.3f} % above the best",
                   line["wall_s"] < 10.0 and above <= 0.1)
    return row(*texts)


def csv_reading(result):
    texts = ("CSV reading", "5 times as fast as pandas.read_csv")
    stage = result["stages"].get("csv", {})
    if "pandas" not in stage:
        return row(*texts)
    ratio = stage["pandas"]["median"]["wall_s"] / stage["lipoid"]["median"]["wall_s"]
    return row(*texts, f"{ratio:.1f} times", ratio >= 5.0)


def peak_memory(result):
    texts = ("peak memory of the whole run", "under 600 MB")
    ours, _ = staged(result)
    if not ours:
        return row(*texts)
    return row(*texts, f"{ours['peak_memory_MB']:.0f} MB", ours["peak_memory_MB"] < 600.0)


def field_tool(result):
    texts = ("PyBOP's published example, fit against fit",
             "1,000 times faster, at no larger sum of squares")
    stage = result["stages"].get("pybop", {})
    if "published" not in stage:
        return row(*texts)
    example = stage["published"]
    ratio = example["pybop"]["median"]["fit_s"] / example["lipoid"]["median"]["fit_s"]
    ours = example["lipoid"]["sum_of_squares_V2"]
    theirs = example["pybop"]["sum_of_squares_V2"]
    return row(*texts, f"{ratio:.0f} times; {ours:.4g} V² against {theirs:.4g} V²",
               ratio >= 1000 and ours <= theirs)


def joint_method(result):
    """One goal for each campaign; none in figures that are older than the stage."""
    stage = result["stages"].get("joint")
    if stage is None:
        return []
    return [joint_run(row_of_campaign) for row_of_campaign in stage["campaigns"]]


def joint_run(measured):
    goal_s = GOALS_S[measured["name"]]
    texts = (f"joint method, {measured['name']}, CSV on disk to cell file",
             f"{goal_s:g} s, at an rmse comparable with SciPy's")
    if "peer" not in measured:
        return row(*texts)
    wall_s = measured["lipoid"]["median"]["wall_s"]
    ours = measured["peer"]["judges"]["lipoid_rmse_V"]
    theirs = measured["peer"]["median"]["rmse_V"]
    ratio = measured["peer"]["median"]["total_s"] / wall_s
    found = (f"{wall_s:.2f} s, {ratio:.1f} times faster than SciPy's fit of one structure; rmse "
             f"{1e3 * ours:.3f} mV, SciPy {1e3 * theirs:.3f} mV")
    return row(*texts, found, wall_s <= goal_s and ours <= COMPARABLE * theirs)
