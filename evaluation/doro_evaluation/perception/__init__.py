"""A detector that looks: boxes, names, calibration, speed, and the chain behind it."""
