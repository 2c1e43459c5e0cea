"""Training of the captioner: a development step, needs the extra ``train``."""
