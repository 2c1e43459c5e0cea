"""Training of the shipped tagger; needs the extra ``train`` (torch, onnx)."""
