"""What belongs to a room itself: doors, windows, curtains, lamps, pictures, sockets."""
