"""Rooms dressed anew: labelled frames to train and to calibrate the captioner."""
