"""Settings of the service, table ``[nlu]``."""

from __future__ import annotations

import msgspec


class NluSettings(msgspec.Struct, frozen=True, kw_only=True):
    """Settings with their defaults.

    Attributes:
        tagger: the shipped tagger: ``default``, the small BERT-family encoder, or ``bilstm``.
        model_dir: directory with ``model.onnx`` and ``vocabulary.json``; empty = the shipped one.
        cache_size: captions whose parse is kept; the least recently used goes first; 0 = none.
        min_object_probability: below it an object is not taken: a reason is given instead. Of
            objects below .6 more than half were wrong (generated sentences).
    """

    tagger: str = "default"
    model_dir: str = ""
    cache_size: int = 10_000
    min_object_probability: float = 0.6
