"""WordPiece on top of the word tokens, and the rows of a batch."""

import numpy as np
import pytest

from doro_nlu.settings import NluSettings
from doro_nlu.tagger import load_tagger
from doro_nlu.wordpiece import BEGIN, END, ROW_PIECES, SPECIALS, UNKNOWN, rows_of, split_word
from doro_schemas.errors import Refused

PIECES = {
    name: index
    for index, name in enumerate([*SPECIALS, "cup", "##s", "red", "yellow", "-", "handle", "##d"])
}


def _ids(*names: str) -> list[int]:
    return [PIECES[name] for name in names]


def test_longest_pieces_first_case_and_accents_dropped() -> None:
    assert split_word("Cups", PIECES) == _ids("cup", "##s")
    assert split_word("réd", PIECES) == _ids("red")
    assert split_word("yellow-handled", PIECES) == _ids("yellow", "-", "handle", "##d")


def test_what_cannot_be_spelt_is_one_unknown_piece() -> None:
    assert split_word("xyz", PIECES) == [UNKNOWN]
    assert split_word("cupx", PIECES) == [UNKNOWN]
    assert split_word("漢", PIECES) == [UNKNOWN]
    assert split_word("\u0301", PIECES) == [UNKNOWN]
    assert split_word("a" * 2000, PIECES) == [UNKNOWN]


def test_rows_mark_first_pieces_and_padding() -> None:
    rows, owners = rows_of([[_ids("red"), _ids("cup", "##s"), _ids("red")], [_ids("cup")]])
    assert owners == [0, 1]
    assert rows.firsts == [[1, 2, 4], [1]]
    assert rows.pieces[0].tolist() == [BEGIN, *_ids("red", "cup", "##s", "red"), END]
    assert rows.pieces[1].tolist() == [BEGIN, *_ids("cup"), END, 0, 0, 0]
    np.testing.assert_array_equal(rows.mask.sum(axis=1), [6, 3])


def test_a_long_sentence_goes_in_several_rows_no_word_lost() -> None:
    words = [_ids("cup", "##s")] * 200
    rows, owners = rows_of([[_ids("red")], words])
    assert rows.pieces.shape[1] <= ROW_PIECES
    assert owners == [0, *[1] * (len(owners) - 1)]
    assert sum(len(firsts) for firsts in rows.firsts[1:]) == 200


def test_unknown_tagger_is_refused() -> None:
    assert NluSettings().tagger == "default"
    with pytest.raises(Refused, match="no tagger is called 'bert'"):
        load_tagger(None, "bert")
    with pytest.raises(Refused, match=r"not shipped.*nlu\.model_dir"):
        load_tagger(None, "bert-base")
