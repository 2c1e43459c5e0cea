"""Household things made of lathes, tubes, blobs and boxes, one file for each kind of thing."""
