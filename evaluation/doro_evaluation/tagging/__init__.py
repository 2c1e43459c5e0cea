"""Tagging (paper, Table I), its speed, and whether whole graphs are right."""
