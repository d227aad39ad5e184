"""The stages of tools/bench, one file each, and the report that is made from what they leave."""
