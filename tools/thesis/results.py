"""The stages, and the text of the JSON that holds their results."""

import json
import re

from . import compensation, controllers, design, hover, poles, square, transients

SCHEMA = "lipoid.thesis-results/1"
STAGES = {
    "poles": poles.measure,
    "altitude": transients.altitude,
    "attitude": transients.attitude,
    "compensation": compensation.measure,
    "controllers": controllers.measure,
    "square": square.measure,
    "hover": hover.measure,
    "design": design.measure,
    "designed": design.flown,
}
SLOW = ("design",)


def text_of(result):
    """JSON with every list of plain numbers on one line."""
    text = json.dumps(result, indent=1, ensure_ascii=False)
    numbers = re.compile(r"\[\s*(-?\d[^\[\]{}\"]*?)\s*\]")
    text = numbers.sub(lambda match: "[" + re.sub(r"\s+", " ", match.group(1)) + "]", text)
    return text + "\n"
