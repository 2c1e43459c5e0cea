"""The core of nlu: text to graph, for instructions, captions and anyone who asks."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Sequence
from pathlib import Path

from doro_nlu.language import not_english
from doro_nlu.parser import Parse, parse, refused
from doro_nlu.reasons import unsure
from doro_nlu.settings import NluSettings
from doro_nlu.tagger import Tagged, Tagger, load_tagger
from doro_nlu.tokens import tokenize
from doro_schemas.effects import Output
from doro_schemas.errors import Refused
from doro_schemas.graph import ObjectGraph, Relation
from doro_schemas.messages import (
    CaptionedBox,
    FrameCaptions,
    FrameGraphs,
    GraphBox,
    Instruction,
    InstructionGraph,
    ParseReply,
    ParseRequest,
)
from doro_schemas.messages.base import MAX_TEXT_CHARS
from doro_schemas.vocabulary import canonical_name, canonical_value

WARM_UP = "bring me the red plastic cup on the table near the sink"


class Understood:
    """A text with its tags and its parse."""

    __slots__ = ("parse", "tagged", "text")

    def __init__(self, text: str, tagged: Tagged, result: Parse) -> None:
        self.text, self.tagged, self.parse = text, tagged, result


class Nlu:
    """Phrase to graph (paper, Section IV-A).

    Args:
        settings: model, cache.
        tagger: another tagger than the shipped one.

    Raises:
        Refused: the model cannot be loaded.
    """

    def __init__(self, settings: NluSettings, tagger: Tagger | None = None) -> None:
        directory = Path(settings.model_dir) if settings.model_dir else None
        self._tagger = load_tagger(directory, settings.tagger) if tagger is None else tagger
        self._settings = settings
        self._cache: OrderedDict[str, Understood] = OrderedDict()
        self.counters = {
            "instructions": 0,
            "captions": 0,
            "not_understood": 0,
            "cache_hits": 0,
        }
        self._understand([WARM_UP])

    def instruction(self, message: Instruction) -> list[Output]:
        """Return the instruction's graph; not understood: no graph, but a reason."""
        self.counters["instructions"] += 1
        reply = self.parse_text(message.text)
        if reply.graph is None:
            self.counters["not_understood"] += 1
        return [
            InstructionGraph(
                stamp_ns=message.stamp_ns,
                episode=message.episode,
                person=message.person,
                text=reply.text,
                task=reply.task,
                tokens=reply.tokens,
                labels=reply.labels,
                graph=reply.graph,
                readings=reply.readings,
                reason=reply.reason,
                confidence=reply.confidence,
                probabilities=reply.probabilities,
                reading_confidences=reply.reading_confidences,
                reason_kind=reply.reason_kind,
            )
        ]

    def captions(self, message: FrameCaptions) -> list[Output]:
        """Return the graphs of a frame's detections, in their order, all captions in one batch.

        A detection that carries a graph passes through with canonical names; captions that
        give no graph are listed in ``not_understood``, the others are kept.
        """
        texts = [box.caption for box in message.detections if box.graph is None]
        parses = dict(zip(texts, self._cached(texts), strict=True))
        boxes: list[GraphBox] = []
        lost: list[str] = []
        for box in message.detections:
            graph = canonical(box.graph) if box.graph else parses[box.caption].parse.graph
            if graph is None:
                lost.append(box.caption)
            else:
                boxes.append(_graph_box(box, graph))
        self.counters["captions"] += len(texts)
        self.counters["not_understood"] += len(lost)
        return [
            FrameGraphs(
                stamp_ns=message.stamp_ns,
                episode=message.episode,
                camera=message.camera,
                frame=message.frame,
                height_px=message.height_px,
                width_px=message.width_px,
                detections=boxes,
                not_understood=lost,
                unnamed=message.unnamed,
                calibrated=message.calibrated,
            )
        ]

    def parse(self, request: ParseRequest) -> ParseReply:
        """Answer a question to the parser."""
        reply = self.parse_text(request.text, caption=request.caption)
        reply.stamp_ns, reply.episode = request.stamp_ns, request.episode
        return reply

    def parse_text(self, text: str, *, caption: bool = False) -> ParseReply:
        """Return tokens, labels and graph of one text; a caption names no task.

        Raises:
            Refused: more characters than an instruction may have.
        """
        if len(text) > MAX_TEXT_CHARS:
            raise Refused(
                f"the text has {len(text)} characters, at most {MAX_TEXT_CHARS} are taken:"
                " say it in a sentence"
            )
        text = text.encode("utf-8", "replace").decode()  # lone surrogates fit on no wire
        understood = (self._cached if caption else self._understand)([text])[0]
        return reply_of(text, understood.tagged, understood.parse, caption=caption)

    def _cached(self, texts: Sequence[str]) -> list[Understood]:
        """Return the parses of captions, new ones run in one batch and kept."""
        known: dict[str, Understood] = {}
        for text in texts:
            if text in self._cache:
                self._cache.move_to_end(text)
                known[text] = self._cache[text]
                self.counters["cache_hits"] += 1
        new = list(dict.fromkeys(text for text in texts if text not in known))
        for text, understood in zip(new, self._understand(new) if new else [], strict=True):
            known[text] = self._cache[text] = understood
        while len(self._cache) > self._settings.cache_size:
            self._cache.popitem(last=False)
        return [known[text] for text in texts]

    def _understand(self, texts: Sequence[str]) -> list[Understood]:
        tokens = [tokenize(text[:MAX_TEXT_CHARS]) for text in texts]
        tagged = self._tagger.tag(tokens)
        return [self._judge(text, item) for text, item in zip(texts, tagged, strict=True)]

    def _judge(self, text: str, tagged: Tagged) -> Understood:
        foreign = not_english(tagged.tokens, self._tagger.knows)
        if foreign:
            return Understood(text, tagged, refused(foreign))
        result = parse(tagged, text)
        if result.graph and result.object_probability < self._settings.min_object_probability:
            result = refused(unsure(result.graph.name, text))
        return Understood(text, tagged, result)


def reply_of(text: str, tagged: Tagged, result: Parse, *, caption: bool = False) -> ParseReply:
    """Return a parse as a message; a caption names no task and may name two things."""
    if result.second and not caption:
        result = refused(result.second)
    reason = result.reason
    return ParseReply(
        text=text,
        task="" if caption else result.task,
        tokens=list(tagged.tokens),
        labels=list(tagged.labels),
        probabilities=list(tagged.probabilities),
        graph=result.graph,
        readings=[reading.graph for reading in result.readings],
        reading_confidences=[reading.share * result.confidence for reading in result.readings],
        reason=reason.text if reason else "",
        reason_kind=reason.kind if reason else "",
        confidence=result.confidence,
    )


def canonical(graph: ObjectGraph) -> ObjectGraph:
    """Return a graph with canonical names and values."""
    return ObjectGraph(
        name=canonical_name(graph.name),
        attributes={kind: canonical_value(value) for kind, value in graph.attributes.items()},
        relations=[
            Relation(item.type, canonical(item.target), item.inverse) for item in graph.relations
        ],
    )


def _graph_box(box: CaptionedBox, graph: ObjectGraph) -> GraphBox:
    return GraphBox(
        box_px=box.box_px,
        score=box.score,
        graph=graph,
        caption=box.caption,
        classes=box.classes,
    )
