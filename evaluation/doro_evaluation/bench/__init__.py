"""Speed and memory of the services."""
