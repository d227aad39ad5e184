"""Curves in panels side by side, as an SVG; and the curves of growth, from the JSON."""

import math

PANEL_WIDTH = 230
PANEL_HEIGHT = 190
LEFT = 62
TOP = 34
GAP = 68
BOTTOM = 46
COLOURS = ("#1f6fb2", "#c8501e", "#3b8a3e", "#7a4fa3")


class Axis:
    """Values to places along an axis, linear or logarithmic, with round ticks. A linear one begins
    at zero, or with `from_zero` off at the least value."""

    def __init__(self, values, length, logarithmic=False, from_zero=True):
        self.logarithmic = logarithmic
        self.length = length
        if logarithmic:
            self.lo = math.floor(math.log10(min(values)) + 1e-9)
            self.hi = math.ceil(math.log10(max(values)) - 1e-9)
            self.hi = max(self.hi, self.lo + 1)
            step = max(1, (self.hi - self.lo + 5) // 6)
            self.ticks = [10.0 ** k for k in range(self.lo, self.hi + 1, step)]
        else:
            least = 0.0 if from_zero else min(values)
            step = round_step((max(values) - least) / 4)
            first = math.floor(least / step + 1e-9)
            last = math.ceil(max(values) / step - 1e-9)
            self.lo = step * first
            self.hi = step * last
            self.ticks = [step * k for k in range(first, last + 1)]

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


def frame(left, title, x_label, across, up):
    """The panel without its curves."""
    base = TOP + PANEL_HEIGHT
    parts = [text(left + PANEL_WIDTH / 2, TOP - 14, title, extra=' font-weight="bold"')]
    for tick in up.ticks:
        y = base - up.place(tick)
        parts.append(f'<path d="M{left} {y:.1f}h{PANEL_WIDTH}" stroke="#ddd"/>')
        parts.append(text(left - 6, y + 4, tick_text(tick, up.logarithmic), "end"))
    for tick in across.ticks:
        x = left + across.place(tick)
        parts.append(f'<path d="M{x:.1f} {base}v4" stroke="#444"/>')
        parts.append(text(x, base + 18, tick_text(tick, across.logarithmic)))
    parts.append(f'<path d="M{left} {TOP}v{PANEL_HEIGHT}h{PANEL_WIDTH}" fill="none" '
                 'stroke="#444"/>')
    parts.append(text(left + PANEL_WIDTH / 2, base + 36, x_label))
    return parts


def line(left, across, up, points, colour):
    places = [(left + across.place(x), TOP + PANEL_HEIGHT - up.place(y)) for x, y in points]
    path = "L".join(f"{x:.1f} {y:.1f}" for x, y in places)
    return f'<path d="M{path}" fill="none" stroke="{colour}" stroke-width="1.6"/>'


def dots(left, across, up, points, colour):
    return [f'<circle cx="{left + across.place(x):.1f}" cy="{TOP + PANEL_HEIGHT - up.place(y):.1f}"'
            f' r="2.6" fill="{colour}"/>' for x, y in points]


def label(left, row, name, colour):
    return text(left + 8, TOP + 14 + 14 * row, name, "start", f' fill="{colour}"')


def panel(left, title, x_label, curves, logarithmic):
    """curves: [(name, [(x, milliseconds)])]."""
    xs = [x for _, points in curves for x, _ in points]
    ys = [y for _, points in curves for _, y in points]
    across = Axis(xs, PANEL_WIDTH, logarithmic)
    up = Axis(ys, PANEL_HEIGHT, logarithmic)
    parts = frame(left, title, x_label, across, up)
    for k, (name, points) in enumerate(curves):
        colour = COLOURS[k % len(COLOURS)]
        parts.append(line(left, across, up, points, colour))
        parts += dots(left, across, up, points, colour)
        if len(curves) > 1:
            parts.append(label(left, k, name, colour))
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
    return document([panel(LEFT + k * (PANEL_WIDTH + GAP), *arguments)
                     for k, arguments in enumerate(panels)])


def document(panels):
    """panels: lists of the parts of each, side by side."""
    width = len(panels) * (PANEL_WIDTH + GAP) + LEFT
    height = TOP + PANEL_HEIGHT + BOTTOM
    parts = [part for panel_parts in panels for part in panel_parts]
    return (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" '
            f'font-family="sans-serif" font-size="11">\n'
            f'<rect width="{width}" height="{height}" fill="#fff"/>\n'
            + "\n".join(parts) + "\n</svg>\n")
