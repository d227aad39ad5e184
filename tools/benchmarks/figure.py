"""The curves of growth as an SVG, drawn from the JSON."""

import math

PANEL_WIDTH = 230
PANEL_HEIGHT = 190
LEFT = 62
TOP = 34
GAP = 68
BOTTOM = 46
COLOURS = ("#1f6fb2", "#c8501e", "#3b8a3e", "#7a4fa3")


class Axis:
    """Values to places along an axis, linear or logarithmic, with round ticks."""

    def __init__(self, values, length, logarithmic):
        self.logarithmic = logarithmic
        self.length = length
        if logarithmic:
            self.lo = math.floor(math.log10(min(values)) + 1e-9)
            self.hi = math.ceil(math.log10(max(values)) - 1e-9)
            self.hi = max(self.hi, self.lo + 1)
            step = max(1, (self.hi - self.lo + 5) // 6)
            self.ticks = [10.0 ** k for k in range(self.lo, self.hi + 1, step)]
        else:
            step = round_step(max(values) / 4)
            self.lo = 0.0
            self.hi = step * math.ceil(max(values) / step - 1e-9)
            self.ticks = [step * k for k in range(round(self.hi / step) + 1)]

    def place(self, value):
        value = math.log10(value) if self.logarithmic else value
        return (value - self.lo) / (self.hi - self.lo) * self.length


def round_step(least):
    """The smallest of 1, 2, 5 times a power of ten that is not below `least`."""
    power = 10.0 ** math.floor(math.log10(least))
    return next(m * power for m in (1, 2, 5, 10) if m * power >= least * (1 - 1e-9))


def tick_text(value, logarithmic):
    if not logarithmic:
        return f"{value:g}"
    exponent = round(math.log10(value))
    return f'10<tspan dy="-4" font-size="8">{exponent}</tspan>'


def text(x, y, content, anchor="middle", extra=""):
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}"{extra}>{content}</text>'


def panel(left, title, x_label, curves, logarithmic):
    """curves: [(name, [(x, milliseconds)])]."""
    xs = [x for _, points in curves for x, _ in points]
    ys = [y for _, points in curves for _, y in points]
    across = Axis(xs, PANEL_WIDTH, logarithmic)
    up = Axis(ys, PANEL_HEIGHT, logarithmic)
    base = TOP + PANEL_HEIGHT
    parts = [text(left + PANEL_WIDTH / 2, TOP - 14, title, extra=' font-weight="bold"')]
    for tick in up.ticks:
        y = base - up.place(tick)
        parts.append(f'<path d="M{left} {y:.1f}h{PANEL_WIDTH}" stroke="#ddd"/>')
        parts.append(text(left - 6, y + 4, tick_text(tick, logarithmic), "end"))
    for tick in across.ticks:
        x = left + across.place(tick)
        parts.append(f'<path d="M{x:.1f} {base}v4" stroke="#444"/>')
        parts.append(text(x, base + 18, tick_text(tick, logarithmic)))
    parts.append(f'<path d="M{left} {TOP}v{PANEL_HEIGHT}h{PANEL_WIDTH}" fill="none" '
                 'stroke="#444"/>')
    parts.append(text(left + PANEL_WIDTH / 2, base + 36, x_label))
    for k, (name, points) in enumerate(curves):
        colour = COLOURS[k % len(COLOURS)]
        places = [(left + across.place(x), base - up.place(y)) for x, y in points]
        path = "L".join(f"{x:.1f} {y:.1f}" for x, y in places)
        parts.append(f'<path d="M{path}" fill="none" stroke="{colour}" stroke-width="1.6"/>')
        parts += [f'<circle cx="{x:.1f}" cy="{y:.1f}" r="2.6" fill="{colour}"/>'
                  for x, y in places]
        if len(curves) > 1:
            parts.append(text(left + 8, TOP + 14 + 14 * k, name, "start",
                              f' fill="{colour}"'))
    return parts


def curve(series, name):
    return name, [(point[series["unit"]], 1e3 * point["wall_s"]) for point in series["points"]]


def draw(growth):
    """The SVG's text. growth: the stage of the JSON."""
    series = growth["series"]
    rows = [curve(series[key], name) for key, name in (
        ("fit", "whole fit"), ("stream", "streamed prediction"), ("prepare", "preparation"),
        ("sweep", "one sweep")) if series[key]["points"]]
    panels = [("rows: time / ms", "rows", rows, True)]
    for key in ("branches", "terms"):
        panels.append((f"{key}: time of a sweep / ms", key, [curve(series[key], key)], False))
    width = len(panels) * (PANEL_WIDTH + GAP) + LEFT
    height = TOP + PANEL_HEIGHT + BOTTOM
    parts = []
    for k, (title, x_label, curves, logarithmic) in enumerate(panels):
        parts += panel(LEFT + k * (PANEL_WIDTH + GAP), title, x_label, curves, logarithmic)
    return (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" '
            f'font-family="sans-serif" font-size="11">\n'
            f'<rect width="{width}" height="{height}" fill="#fff"/>\n'
            + "\n".join(parts) + "\n</svg>\n")
