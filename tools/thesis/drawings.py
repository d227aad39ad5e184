"""The drawings of the results, from the JSON alone."""

from benchmarks.figure import (COLOURS, GAP, LEFT, PANEL_HEIGHT, PANEL_WIDTH, TOP, Axis, document,
                               dots, frame, label, line, text)

FASTEST_SHOWN_PER_S = -12.0  # the motors' own pole is at about -55


def heat(xi, least=0.8, most=1.0):
    """Red for an empty battery, blue for a full one, as the thesis has it."""
    share = min(max((xi - least) / (most - least), 0.0), 1.0)
    red, blue = round(200 * (1.0 - share)) + 20, round(180 * share) + 30
    return f"#{red:02x}30{blue:02x}"


def place(k):
    return LEFT + k * (PANEL_WIDTH + GAP)


def axes(points, from_zero=True):
    xs, ys = zip(*points)
    return (Axis(xs, PANEL_WIDTH, from_zero=from_zero),
            Axis(ys, PANEL_HEIGHT, from_zero=from_zero))


def poles(stage):
    panels = []
    for k, loop in enumerate(stage["loops"]):
        points = [(row["xi"], pole) for row in loop["rows"] for pole in row["poles_full"]
                  if pole[0] > FASTEST_SHOWN_PER_S]
        across, up = axes([pole for _, pole in points] + [[0.0, 0.0]], from_zero=False)
        parts = frame(place(k), f"{loop['loop']}, {loop['gains']} (Fig {loop['figure']})",
                      "real part / s⁻¹", across, up)
        for xi, pole in points:
            parts += dots(place(k), across, up, [pole], heat(xi))
        parts += [label(place(k), row, f"xi = {xi}", heat(xi))
                  for row, xi in enumerate((1.0, 0.9, 0.8))]
        panels.append(parts)
    return document(panels)


def transients(stage, unit):
    panels = []
    for k, series in enumerate(stage):
        curves = [(curve["xi"], [(row * series["step_s"], error)
                                 for row, error in enumerate(curve["error"])])
                  for curve in series["curves"]]
        every = [point for other in stage if other["model"] == series["model"]
                 for point in ((row * other["step_s"], error) for curve in other["curves"]
                               for row, error in enumerate(curve["error"]))]
        across, up = axes(every, from_zero=False)
        parts = frame(place(k), f"{series['gains']}, {series['model']}: error / {unit}",
                      "time since the step / s", across, up)
        for row, (xi, points) in enumerate(reversed(curves)):
            parts.append(line(place(k), across, up, points, heat(xi)))
            parts.append(text(place(k) + PANEL_WIDTH - 4, TOP + 14 + 14 * row, f"xi = {xi}", "end",
                              f' fill="{heat(xi)}"'))
        panels.append(parts)
    return document(panels)


def compensation(stage):
    flights = [flight for flight in stage if "curves" in flight]
    panels = []
    for vehicle in dict.fromkeys(flight["vehicle"] for flight in flights):
        for key, title, scale in (("error_m", "absolute error / mm", 1e3),
                                  ("battery_V", "voltage / V", 1.0)):
            curves = [(flight["compensated"],
                       [(row * flight["step_s"], scale * value)
                        for row, value in enumerate(flight["curves"][key])])
                      for flight in flights if flight["vehicle"] == vehicle]
            across, up = axes([point for _, points in curves for point in points],
                              from_zero=False)
            left = place(len(panels))
            parts = frame(left, f"{vehicle}: {title}", "time / s", across, up)
            for compensated, points in reversed(curves):
                parts.append(line(left, across, up, points, COLOURS[compensated]))
                name = "measured voltage" if compensated else "nominal voltage"
                parts.append(label(left, compensated, name, COLOURS[compensated]))
            panels.append(parts)
    return document(panels)
