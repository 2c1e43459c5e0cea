"""The next view worth taking."""
