"""Own annotations: what is read, what is refused and with which words, the table, a tiny run."""

import json
import sys
from pathlib import Path

import pytest

from doro_nlu.labels import LABELS
from doro_nlu.tagger import load_tagger
from doro_nlu.train.annotate import Example, annotate
from doro_nlu.train.evaluate import evaluate
from doro_nlu.train.tune import table, tune
from doro_nlu.train.tune_data import extended, read_annotations, split
from doro_nlu.train.tune_job import Job
from doro_schemas.errors import Refused

TEXT = "bring the {C red} {O cup} {P on} the {R table}"


def json_lines(path: Path, examples: list[Example]) -> Path:
    rows = [json.dumps({"tokens": e.tokens, "labels": e.labels}) for e in examples]
    path.write_text("\n".join(rows) + "\n", encoding="utf-8")
    return path


def many(count: int) -> list[Example]:
    return [annotate(TEXT.replace("cup", f"cup{number}")) for number in range(count)]


def test_json_lines_and_bio_read_the_same(tmp_path: Path) -> None:
    examples = many(12)
    rows = ["\n".join(f"{t}\t{label}" for t, label in zip(*e, strict=True)) for e in examples]
    bio = tmp_path / "data.bio"
    bio.write_text("\n\n".join(rows) + "\n", encoding="utf-8")
    assert read_annotations(json_lines(tmp_path / "data.jsonl", examples), LABELS) == examples
    assert read_annotations(bio, LABELS) == examples


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("{", "line 11 is not JSON"),
        ("[1]", "line 11 has no 'tokens' and 'labels'"),
        ('{"tokens": ["a"], "labels": [3]}', "lists of texts"),
        ('{"tokens": [], "labels": []}', "line 11 has 0 tokens"),
        ('{"tokens": ["a", "b"], "labels": ["O"]}', "2 tokens and 1 labels"),
        ('{"tokens": ["a b"], "labels": ["O"]}', "with a space in it"),
        ('{"tokens": ["a"], "labels": ["cup"]}', "line 11 has the label 'cup' at token 1"),
        ('{"tokens": ["a"], "labels": ["B-Size"]}', "lower-case"),
        ('{"tokens": ["a"], "labels": ["I-color"]}', "I-color at token 1 after O: begin with B-"),
        ('{"tokens": ["a"], "labels": ["B-size"]}', "add --extend"),
    ],
)
def test_a_bad_json_line_is_named(tmp_path: Path, line: str, words: str) -> None:
    path = json_lines(tmp_path / "data.jsonl", many(10))
    path.write_text(path.read_text(encoding="utf-8") + line + "\n", encoding="utf-8")
    with pytest.raises(Refused, match=words) as refused:
        read_annotations(path, LABELS)
    assert "data.jsonl line 11" in refused.value.reason


def test_bad_bio_lines_few_sentences_and_no_file(tmp_path: Path) -> None:
    path = tmp_path / "data.bio"
    path.write_text("cup B-object\nred C B-color\n", encoding="utf-8")
    with pytest.raises(Refused, match=r"data\.bio line 2 has 3 columns"):
        read_annotations(path, LABELS)
    path.write_text("cup B-object\n", encoding="utf-8")
    with pytest.raises(Refused, match="holds 1 sentences, at least 10"):
        read_annotations(path, LABELS)
    with pytest.raises(Refused, match="cannot be read"):
        read_annotations(tmp_path / "none.jsonl", LABELS)
    path.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(Refused, match="UTF-8"):
        read_annotations(path, LABELS)


def test_new_types_extend_the_label_set(tmp_path: Path) -> None:
    new = Example(["the", "big", "cup"], ["O", "B-size", "B-object"])
    path = json_lines(tmp_path / "data.jsonl", [*many(10), new])
    found = read_annotations(path, LABELS, extend=True)
    assert extended(LABELS, found) == [*LABELS, "B-size", "I-size"]
    assert extended(LABELS, many(3)) == list(LABELS)


def test_the_split_is_seeded_and_keeps_equal_sentences_together() -> None:
    examples = many(20) * 2
    parts = split(examples, 1)
    assert parts == split(examples, 1) != split(examples, 2)
    assert len(parts.train) + len(parts.test) == 40
    assert len(parts.test) == 8
    assert not {tuple(e.tokens) for e in parts.test} & {tuple(e.tokens) for e in parts.train}


def test_the_table_shows_what_occurs_before_and_after() -> None:
    tagger = load_tagger()
    known = evaluate(tagger, many(3))
    new = evaluate(tagger, [Example(["big", "cup"], ["B-size", "B-object"])])
    text = table({"own": (new, new), "generated": (known, known)})
    assert "| B-size | 0.000 | 0.000 | - | - |" in text
    assert "| sentences | 1 | 1 | 3 | 3 |" in text
    assert "B-material" not in text


def test_without_torch_the_extra_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "torch", None)
    for name in [name for name in sys.modules if name.startswith("doro_nlu.train.tune_fit")]:
        monkeypatch.delitem(sys.modules, name)
    path = json_lines(tmp_path / "data.jsonl", many(10))
    with pytest.raises(Refused, match=r"doro-nlu\[train\]"):
        tune(Job(data=path, out=tmp_path / "out"))


def test_a_tiny_run_learns_a_new_type(tmp_path: Path) -> None:
    pytest.importorskip("torch", reason="the extra train is not installed")
    pytest.importorskip("onnx", reason="the extra train is not installed")
    names = "cup box vase book lamp bowl fork pen pan pot mug key".split()  # noqa: SIM905
    sizes = ("tiny", "huge", "big")
    data = [
        Example(["bring", "the", size, name], ["O", "O", "B-size", "B-object"])
        for name in names
        for size in sizes
    ]
    path = json_lines(tmp_path / "data.jsonl", data)
    reports = tune(Job(data=path, out=tmp_path / "out", extend=True, steps=60, rate=3e-4))
    before, after = reports["own sentences, held out"]
    assert before.entity_f1 < after.entity_f1 > 0.9
    kept = reports["generated, templates never trained on"]
    assert kept[1].weighted_f1 > kept[0].weighted_f1 - 0.05
    tagged = load_tagger(tmp_path / "out").tag([["find", "the", "huge", "shovel"]])[0]
    assert tagged.labels == ["O", "O", "B-size", "B-object"]
