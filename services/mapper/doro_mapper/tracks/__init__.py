"""Finder "tracks": online association, merging, pruning; what counts as an instance."""
