"""CoNLL-U in, graph out: forty hand-made trees with their graphs, and input that is refused."""

import io
import json
from pathlib import Path

import pytest
from nlu_sentences import show

from doro_console.lines import parse_trees
from doro_nlu.conllu import MAX_NESTED, MAX_WORDS, read_conllu
from doro_nlu.dependencies import label
from doro_nlu.from_conllu import parse_conllu
from doro_schemas.errors import Refused

TREES = (Path(__file__).parent / "nlu_dependencies.conllu").read_text(encoding="utf-8")
EXPECTED = [line.split(" = ")[1] for line in TREES.splitlines() if line.startswith("# graph = ")]


def row(number: int, form: str, head: object, deprel: str = "dep", upos: str = "NOUN") -> str:
    return "\t".join([str(number), form, form, upos, "_", "_", str(head), deprel, "_", "_"])


CUP = f"{row(1, 'red', 2, 'amod', 'ADJ')}\n{row(2, 'cup', 0, 'root')}\n"


def test_the_graphs_of_the_trees() -> None:
    assert len(EXPECTED) == 40
    found = parse_conllu(TREES)
    got = [
        show(one.reply.graph) if one.reply.graph else f"!{one.reply.reason_kind}" for one in found
    ]
    assert got == EXPECTED


def test_the_tree_decides_the_attachment_and_the_other_one_stays_a_reading() -> None:
    same_words = [one.reply for one in parse_conllu(TREES) if one.id in ("d33", "d34")]
    flat, nested = "cup(is-on table)(is-near sink)", "cup(is-on table(is-near sink))"
    assert same_words[0].text == same_words[1].text
    assert [show(one.graph) for one in same_words] == [flat, nested]
    assert [[show(one) for one in reply.readings] for reply in same_words] == [[nested], [flat]]


def test_labels_are_those_of_the_guide() -> None:
    sentence = next(one for one in read_conllu(TREES) if one.id == "d29")
    tagged = label(sentence).tagged
    spans = [f"{t}/{x}" for t, x in zip(tagged.tokens, tagged.labels, strict=True) if x != "O"]
    assert spans == [
        "glass/B-object", "of/I-object", "water/I-object",
        "in/B-is-near", "front/I-is-near", "of/I-is-near", "tv/B-related",
    ]  # fmt: skip


def test_multiword_tokens_empty_nodes_and_comments_are_skipped() -> None:
    text = "# newdoc\n# a remark\n1-2\tcup's\t_\t_\t_\t_\t_\t_\t_\t_\n" + CUP + "2.1\tx" + "\t_" * 8
    (found,) = parse_conllu(text + "\n\n\n")
    assert (found.id, found.reply.text) == ("1", "red cup")
    assert show(found.reply.graph) == "cup{color=red}"
    assert parse_conllu("") == []


MALFORMED = [
    ("1\tcup\tcup\n", 1, "3 columns"),
    ("# text = a cup\nno columns at all\n", 2, "1 columns"),
    (CUP + row(4, "x", 2), 3, "word 4 where 3 is due"),
    (f"{row(1, 'cup', 0)}\n{row(2, 'x', 7)}", 2, "head 7 of 'x' is not there"),
    (row(1, "cup", "first"), 1, "HEAD is 'first', not a number"),
    (row(1, "cup", "_"), 1, "the column HEAD is empty"),
    (f"{row(1, 'a', 0)}\n{row(2, 'b', 0)}", 2, "one root"),
    (f"{row(1, 'a', 2)}\n{row(2, 'b', 1)}", 1, "one root"),
    (f"{row(1, 'a', 0)}\n{row(2, 'b', 3)}\n{row(3, 'c', 2)}", 2, "in a circle"),
    (CUP + "\n# sent_id = 2\n\n", 4, "without words"),
    ("\n".join(row(n + 1, "x", n) for n in range(MAX_WORDS + 1)), 1, f"{MAX_WORDS + 1} words"),
    ("\n".join(row(n + 1, "x", n) for n in range(99)), MAX_NESTED + 1, "heads below the root"),
]


@pytest.mark.parametrize(("text", "line", "words"), MALFORMED)
def test_malformed_input_is_refused_with_its_line(text: str, line: int, words: str) -> None:
    with pytest.raises(Refused, match=rf"line {line}: .*{words}") as caught:
        parse_conllu(text)
    assert "\n" not in caught.value.reason


def test_every_cut_gives_a_graph_a_reason_or_a_refusal() -> None:
    for length in range(0, len(TREES), 97):
        try:
            found = parse_conllu(TREES[:length])
        except Refused:
            continue
        assert all((one.reply.graph is None) == bool(one.reply.reason) for one in found)


def test_any_tree_over_any_words_is_read() -> None:
    """Labels shuffled over the trees: odd ones must neither crash nor loop."""
    rows = [line.split("\t") for line in TREES.splitlines() if line and line[0] != "#"]
    relations = [columns[7] for columns in rows]
    for shift in range(1, 60, 7):
        number = iter(relations[shift:] + relations[:shift])
        text = "\n".join(
            "\t".join([*c[:7], next(number), *c[8:]]) if (c := line.split("\t"))[1:] else line
            for line in TREES.splitlines()
        )
        assert len(parse_conllu(text)) == 40


def test_records_of_the_command() -> None:
    (record,) = parse_trees(io.StringIO(CUP), caption=False, labels=True)
    assert record["graph"]["attributes"] == {"color": "red"}
    assert record["labels"] == ["B-color", "B-object"]
    assert json.dumps(record)
    broken = io.TextIOWrapper(io.BytesIO(b"1\t\xff"), encoding="utf-8")
    with pytest.raises(Refused, match="UTF-8"):
        list(parse_trees(broken, caption=False, labels=False))
