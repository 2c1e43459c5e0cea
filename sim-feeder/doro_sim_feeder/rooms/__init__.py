"""Rooms of AI2-THOR rendered without Unity: layout, meshes, ray casting, ground truth."""
