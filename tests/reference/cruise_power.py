#!/usr/bin/env python3
"""Power of a copter over its speed, from a DataFlash log of ArduPilot with CURR, GPS and CTUN.

    tests/reference/cruise_power.py log171.bin

Takes the rows in which the vehicle neither climbs nor sinks by more than 0.5 m/s within a second and its speed over
the ground changes by less than 1.5 m/s in it, in bins of speed. The speed is that over the ground: the wind is not
known. log171.bin, a 3DR Solo, is from dronekit/dronekit-la-testdata (CC BY-SA 3.0), commit 6240871; the part of it in
fixtures/flights has no GPS.
"""

import pathlib
import struct
import sys

import numpy

CODES = {"b": "b", "B": "B", "h": "h", "H": "H", "i": "i", "I": "I", "f": "f", "n": "4s", "N": "16s", "Z": "64s",
         "c": "h", "C": "H", "e": "i", "E": "I", "L": "i", "d": "d", "M": "B", "q": "q", "Q": "Q", "a": "64s"}
HUNDREDTHS = "cCeE"
FORMAT = 0x80
FIRST = (89, "FMT", "BBnNZ", ["Type", "Length", "Name", "Format", "Columns"])


def messages(data):
    """Of each name, its columns."""
    formats = {FORMAT: FIRST}
    rows = {}
    at = 0
    while at + 3 < len(data):
        known = formats.get(data[at + 2]) if data[at:at + 2] == b"\xa3\x95" else None
        if known is None or at + known[0] > len(data):
            at += 1
            continue
        length, name, codes, columns = known
        values = struct.unpack_from("<" + "".join(CODES[c] for c in codes), data, at + 3)
        if name == "FMT":
            text = [value.rstrip(b"\0").decode() for value in values[2:]]
            formats[values[0]] = (values[1], text[0], text[1], text[2].split(","))
        elif name in ("CURR", "GPS", "CTUN"):
            rows.setdefault(name, []).append([value * (0.01 if code in HUNDREDTHS else 1.0)
                                              for value, code in zip(values, codes)])
        at += length
    return {name: dict(zip(next(f[3] for f in formats.values() if f[1] == name), numpy.array(of).T))
            for name, of in rows.items()}


def main():
    found = messages(pathlib.Path(sys.argv[1]).read_bytes())
    time_s = 1e-3 * found["CURR"]["TimeMS"]
    power_W = 1e-4 * found["CURR"]["Volt"] * found["CURR"]["Curr"]  # both in hundredths
    speed = numpy.interp(time_s, 1e-3 * found["GPS"]["T"], found["GPS"]["Spd"])
    climb = numpy.interp(time_s, 1e-3 * found["CTUN"]["TimeMS"], 0.01 * found["CTUN"]["CRt"])
    steady = []
    for at in time_s:
        near = abs(time_s - at) <= 0.5
        steady.append(abs(climb[near]).max() < 0.5 and numpy.ptp(speed[near]) < 1.5 and power_W[near].min() > 100.0)
    steady = numpy.array(steady)
    print("speed over the ground / m/s   rows   mean power / W")
    for low, high in ((0, 0.5), (0.5, 2), (2, 4), (4, 6), (6, 8), (8, 10), (10, 13)):
        rows = steady & (speed >= low) & (speed < high)
        if rows.sum() >= 20:
            print(f"{speed[rows].mean():10.2f} {rows.sum():22d} {power_W[rows].mean():15.1f}")


if __name__ == "__main__":
    main()
