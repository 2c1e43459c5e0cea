"""The generator: exact labels, seeds, and frames that stay apart."""

import itertools

from doro_nlu.labels import LABELS, may_follow
from doro_nlu.train.evaluate import held_out_examples
from doro_nlu.train.frames import FRAMES, frames_of
from doro_nlu.train.generate import Generator


def test_held_out_frames_are_never_trained_on() -> None:
    for kind in FRAMES:
        trained, held_out = set(frames_of(kind, False)), set(frames_of(kind, True))
        assert not trained & held_out
        assert held_out


def test_labels_fit_the_tokens_and_the_scheme() -> None:
    for held_out in (False, True):
        for tokens, labels in itertools.islice(Generator(5, held_out=held_out), 3000):
            assert len(tokens) == len(labels) > 0
            assert set(labels) <= set(LABELS)
            assert all(may_follow(a, b) for a, b in itertools.pairwise(["O", *labels]))


def test_a_seed_gives_the_same_sentences() -> None:
    first, again, other = (list(itertools.islice(Generator(s), 50)) for s in (3, 3, 4))
    assert first == again != other


def test_the_test_split_is_large_enough() -> None:
    labels = [label for example in held_out_examples(7) for label in example.labels]
    assert sum(label != "O" for label in labels) > 590
    assert set(labels) == set(LABELS)
