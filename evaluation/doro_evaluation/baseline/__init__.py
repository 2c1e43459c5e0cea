"""The paper's baseline (Section V-D): an encoder-decoder from captions and instruction to query.

Figures of it stand beside ours. Only ``network``, ``train`` and ``export`` need torch.
"""

from doro_evaluation.baseline.model import MISSING, MODEL_DIR, Baseline, available, load

__all__ = ["MISSING", "MODEL_DIR", "Baseline", "available", "load"]
