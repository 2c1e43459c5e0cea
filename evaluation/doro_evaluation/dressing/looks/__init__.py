"""Textures, and the colours that things come in and are called by."""
