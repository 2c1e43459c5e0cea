"""The files of a study: the key that the researcher keeps, and a participant's answers.

The questionnaire (``study.html``) holds pictures, instructions and queries, and no word of
who asked. What belongs to whom stands in the key beside it (``study.json``); a digest in all
three files says that they belong together.
"""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Literal, TypeVar

import msgspec

from doro_schemas.errors import Refused
from doro_schemas.graph import ObjectGraph
from doro_schemas.messages.talk import Clause, State

KEY_SCHEMA, ANSWERS_SCHEMA, VERSION = "doro.study", "doro.study.answers", 1
SCALES = ("informative", "natural")
LIKERT = range(1, 6)
MAX_BYTES = 64 << 20
T = TypeVar("T")


class KnownInstance(msgspec.Struct, frozen=True):
    """An instance as the asking system knew it."""

    id: str
    graph: ObjectGraph


class Asked(msgspec.Struct, frozen=True):
    """A query with what is needed to understand an answer to it.

    Attributes:
        text: what is said.
        state: None where a text came without its decision.
        instances: all instances that the system knew; clauses name them.
        intended: those of them that are what the participant is told to want; empty where
            the system has not found it.
        graph: what the system understood; None: what is true, the item's own.
    """

    text: str
    state: State | None = None
    clauses: list[Clause] = []
    instances: list[KnownInstance] = []
    intended: list[str] = []
    graph: ObjectGraph | None = None


class Unit(msgspec.Struct, frozen=True):
    """One text to be rated, and what each system that says it meant; ids tell nothing."""

    id: str
    text: str
    asked: dict[str, Asked]


class Item(msgspec.Struct, frozen=True):
    """A scene with an instruction.

    Attributes:
        state: what is right to tell, by the truth.
        marks: letters in the pictures and the true objects behind them.
        wanted: letters of what the participant is told to want; empty where nothing of the
            class is there, or the robot did not ask for it.
    """

    id: str
    recording: str
    instruction: str
    task: str
    graph: ObjectGraph
    state: State
    marks: dict[str, str]
    wanted: list[str]
    units: list[Unit]


class Check(msgspec.Struct, frozen=True):
    """An attention check: the ratings that its text asks for."""

    id: str
    informative: int
    natural: int


class Study(msgspec.Struct, frozen=True, kw_only=True):
    """The key of a study.

    Attributes:
        design: ``one``: a participant sees each scene with one of its texts, in turns;
            ``all``: with all of them.
        digest: of everything else; the questionnaire and its answers carry it.
    """

    id: str
    seed: int
    design: Literal["one", "all"]
    systems: list[str]
    items: list[Item]
    checks: list[Check]
    schema: str = KEY_SCHEMA
    version: int = VERSION
    digest: str = ""


class Rating(msgspec.Struct, frozen=True):
    """A participant's word on one unit.

    Attributes:
        position: 0 for what was shown first.
        reply: what the participant would answer; empty with ``cannot_tell``.
    """

    item: str
    unit: str
    position: int
    informative: int
    natural: int
    reply: str = ""
    cannot_tell: bool = False
    seconds: float = 0.0


class StudyName(msgspec.Struct, frozen=True):
    """Which study a file belongs to."""

    id: str
    digest: str


class Answers(msgspec.Struct, frozen=True, kw_only=True):
    """What a participant's browser saves."""

    schema: str
    version: int
    study: StudyName
    participant: str
    consent: bool
    answers: list[Rating]
    checks: list[Check]
    started: str = ""
    finished: str | None = None


def with_digest(study: Study) -> Study:
    """Return a key with its digest filled in."""
    bare = msgspec.json.encode(msgspec.structs.replace(study, digest=""))
    return msgspec.structs.replace(study, digest=hashlib.sha256(bare).hexdigest()[:16])


def write_key(path: Path, study: Study) -> None:
    """Write the key, readable."""
    path.write_bytes(msgspec.json.format(msgspec.json.encode(study), indent=1) + b"\n")


def key_path(page: Path) -> Path:
    """Return where the key of a questionnaire lies: beside it, ``.json`` for ``.html``."""
    return page.with_suffix(".json")


def read_key(path: Path) -> Study:
    """Return the key of a study, from itself or from the questionnaire beside it.

    Raises:
        Refused: it is missing, no key, or was changed.
    """
    beside = key_path(path)
    if path != beside and not beside.is_file():
        raise Refused(
            f"{path.name} names no systems, so that participants are blind to them: its key"
            f" {beside.name} must lie beside it"
        )
    study = _read(beside, Study, "key of a study", KEY_SCHEMA)
    if with_digest(study).digest != study.digest:
        raise Refused(f"{beside} was changed after it was made: take the key as it was written")
    return study


def read_answers(path: Path, study: Study) -> Answers:
    """Return one participant's answers, checked against the study.

    Raises:
        Refused: one sentence: another study, a rating out of range, an unknown scene, a scene
            twice, no consent, or a check or scene that is missing.
    """
    answers = _read(path, Answers, "file of answers", ANSWERS_SCHEMA)
    if answers.study.digest != study.digest:
        raise Refused(
            f"{path} answers study '{answers.study.id}' ({answers.study.digest}), not"
            f" '{study.id}' ({study.digest}): score it with its own key"
        )
    problem = _problem(answers, study)
    if problem:
        raise Refused(f"{path}: {problem}")
    return answers


def _problem(answers: Answers, study: Study) -> str:
    """Return what is wrong with a file of answers, empty if nothing is."""
    if not answers.participant.strip():
        return "the participant has no id: write one into the file"
    if not answers.consent:
        return "the participant did not consent: leave the file out"
    return _wrong_rating(answers, study) or _unfinished(answers, study)


def _wrong_rating(answers: Answers, study: Study) -> str:
    units = {unit.id: item.id for item in study.items for unit in item.units}
    seen: set[str] = set()
    for one in answers.answers:
        where = f"scene {one.item}, query {one.unit}"
        if units.get(one.unit) != one.item:
            return f"{where} is not in the study: was the file edited?"
        if one.unit in seen:
            return f"{where} is rated twice: leave one of them in"
        seen.add(one.unit)
        if not {one.informative, one.natural} <= {*LIKERT}:
            return f"{where} has a rating outside 1 to 5: correct or remove it"
    return ""


def _unfinished(answers: Answers, study: Study) -> str:
    end = "the questionnaire is unfinished"
    given = {one.id for one in answers.checks}
    if missing := [one.id for one in study.checks if one.id not in given]:
        return f"the attention check {missing[0]} is not answered: {end}"
    rated = {one.unit for one in answers.answers}
    for item in study.items:
        units = [unit.id for unit in item.units if unit.id in rated]
        if not units or (study.design == "all" and len(units) < len(item.units)):
            return f"scene {item.id} is not rated as the study asks: {end}"
    return ""


def passed_checks(answers: Answers, study: Study) -> bool:
    """Tell whether every attention check was answered as its text asks."""
    given = {one.id: one for one in answers.checks}
    return all(given.get(one.id) == one for one in study.checks)


def _read(path: Path, kind: type[T], what: str, schema: str) -> T:
    try:
        if path.stat().st_size > MAX_BYTES:
            raise Refused(f"{path} is larger than {MAX_BYTES >> 20} MB: this is no {what}")
        raw = path.read_bytes()
        head = msgspec.json.decode(raw)
        if not isinstance(head, dict) or head.get("schema") != schema:
            raise Refused(f'{path} is no {what}: its "schema" is not {schema}')
        if head.get("version") != VERSION:
            raise Refused(f"{path} has version {head.get('version')}, this program reads {VERSION}")
        return msgspec.json.decode(raw, type=kind)
    except OSError as error:
        raise Refused(f"{path} cannot be read: {error.strerror}") from error
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        raise Refused(f"{path} is no {what}: {error}") from error
