"""What hovers on what, and how long."""

VEHICLES = ("mambo-thesis", "mambo-coupled", "mambo-physical")
SMALL_CELLS = ("gifi-600mAh-1", "gifi-600mAh-2", "gifi-600mAh-3")
CELLS = (*SMALL_CELLS, "grepow-32Ah-1", "grepow-32Ah-2", "grepow-32Ah-3")
LONGEST_S = 100000


def measure(lipoid, cells=CELLS):
    return {
        "command": lipoid.shown(*words("VEHICLE", "CELL")),
        "rows": [row(lipoid, vehicle, cell) for vehicle in VEHICLES for cell in cells],
    }


def words(vehicle, cell):
    return ["fly", "endurance", "--vehicle", vehicle, "--cell", cell, "--duration", LONGEST_S]


def row(lipoid, vehicle, cell):
    # It ends with an empty battery: exit code 1.
    summary = lipoid.summary(*words(vehicle, cell), expected=(1,))
    trim = summary["trim"]
    result = {"vehicle": vehicle, "cell": cell, "hovers": trim["possible"],
              "speed_rad_per_s": trim["speed_rad_per_s"], "duty": trim["duty"]}
    if trim["possible"]:
        result.update(battery_V=trim["battery_V"], battery_A=trim["battery_A"],
                      outcome=summary["outcome"], endurance_s=summary["simulated_s"],
                      charge_C=summary["charge_C"], final_soc=summary["final_soc"])
    return result
