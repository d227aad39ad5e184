"""Whether results flown anew are those of the JSON.

Not to the last bit: another compiler rounds otherwise, and a rounding can turn a pulse width (6.1),
which is an integer, up instead of down. Moving xi and the first state of charge by 1e-13 does the
same. It was measured to move peaks and charges by up to 5e-5 of them, mean square pitch errors by
0.5 % or 6e-4 degrees² (weak gains keep a kick for seconds) and a spread over ten noisy flights by
2.4 %. Ten times that is allowed.
"""

# By key: relative, absolute. Of several names in a path the first one here counts.
DEFAULT = (5e-4, 1e-6)
TOLERANCES = {
    "estimated": (0.25, 1e-3),
    "mse_pitch_deg2": (0.05, 6e-3),
    "mse_altitude_m2": (1e-3, 1e-9),
    "largest_difference_of_two_ways": (0.0, 1e-12),
    "battery_V": (0.0, 0.05),  # a single pulse width: 4 mV
    "error_m": (0.02, 1e-5),
    "error": (0.01, 1e-4),
}


def tolerance(path):
    return next((pair for name, pair in TOLERANCES.items() if name in path), DEFAULT)


def differences(new, old, path=()):
    """Sentences that say where."""
    where = "/".join(map(str, path))
    if isinstance(old, dict) and isinstance(new, dict):
        for key in sorted(old.keys() | new.keys()):
            if key not in old or key not in new:
                yield f"{where}/{key}: only in the {'old' if key in old else 'new'} results"
            else:
                yield from differences(new[key], old[key], (*path, key))
    elif isinstance(old, list) and isinstance(new, list) and len(old) == len(new):
        for k, (a, b) in enumerate(zip(new, old)):
            yield from differences(a, b, (*path, k))
    elif is_number(old) and is_number(new):
        relative, absolute = tolerance(path)
        if not abs(new - old) <= relative * abs(old) + absolute:
            yield f"{where}: {new!r}, in the JSON {old!r}"
    elif old != new:
        yield f"{where}: {short(new)}, in the JSON {short(old)}"


def is_number(value):
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def short(value):
    text = repr(value)
    return text if len(text) < 80 else text[:77] + "..."
