"""Thousands of campaigns on one machine or many: the command ``lipoid-fleet`` (docs/fleet.md)."""
