"""The viewer: a listener that shows a run in Rerun and draws the final map as a PNG."""
