"""Dialogue: decide whether the words single out one instance, and ask where they do not."""
