"""The mean of several training runs' weights."""

import pytest

torch = pytest.importorskip("torch", reason="the extra train is not installed")
pytest.importorskip("onnx", reason="the extra train is not installed")

from doro_perception.train.__main__ import pace  # noqa: E402
from doro_perception.train.soup import mixed  # noqa: E402


def test_weights_are_averaged_by_their_shares() -> None:
    one = {"w": torch.tensor([1.0, 2.0]), "steps": torch.tensor(3)}
    other = {"w": torch.tensor([5.0, 2.0]), "steps": torch.tensor(9)}
    found = mixed([one, other], [3.0, 1.0])
    assert found["w"].tolist() == [2.0, 2.0]
    assert found["steps"].item() == 3


def test_runs_of_two_networks_are_refused() -> None:
    one, other = {"w": torch.zeros(1)}, {"v": torch.zeros(1)}
    with pytest.raises(SystemExit, match="run 2 is of another network"):
        mixed([one, other], [1.0, 1.0])
    with pytest.raises(SystemExit, match="2 runs, but 1 shares"):
        mixed([one, one], [1.0])


def test_large_weights_learn_in_larger_steps() -> None:
    small, large = torch.full((4,), 0.03), torch.full((4,), 0.27)
    usual = pace("backbone.stem.conv.weight", small)
    assert pace("backbone.stem.conv.weight", large) == pytest.approx(3 * usual)
    assert pace("backbone.stem.conv.bias", large) == pytest.approx(usual)
    assert pace("hidden.weight", large) == 1.0
