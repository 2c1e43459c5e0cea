"""Contracts of DoRO: messages, topics, codec and bus. The only package all others share."""
