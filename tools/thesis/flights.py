"""The flights of chapter 6 as pages to replay: those that the thesis compares lie over one another."""

# What is flown for each page, by file name: the words after `lipoid fly`.
CELL = ["--cell", "gifi-600mAh-1", "--vehicle", "mambo-coupled", "--gains", "aware"]
XI = ["--battery", "ideal", "--xi", "0.8", "--gains"]
PAGES = {
    "altitude": [["altitude-steps", *XI, "unaware"], ["altitude-steps", *XI, "aware"]],
    "attitude": [["attitude-doublets", *XI, "unaware"], ["attitude-doublets", *XI, "aware"]],
    "compensation": [["altitude-steps", *CELL], ["altitude-steps", *CELL, "--compensate"]],
    "square": [["square", *CELL, "--set", f"controller.attitude_omega_rad_per_s={omega}"]
               for omega in (100, 200)],
}


def write(lipoid, folder):
    """Flies them all and writes folder/NAME.html; returns the files."""
    folder.mkdir(parents=True, exist_ok=True)
    pages = []
    for name, flights in PAGES.items():
        summaries = []
        for k, words in enumerate(flights):
            summaries.append(folder / f"{name}-{k + 1}.json")
            lipoid.run("fly", *words, "--summary", summaries[-1])
        pages.append(folder / f"{name}.html")
        lipoid.run("report", *summaries, "-o", pages[-1])
    return pages
