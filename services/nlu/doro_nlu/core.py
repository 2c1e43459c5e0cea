"""The core of nlu: text to graph, for instructions, captions and anyone who asks."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Sequence
from pathlib import Path

from doro_nlu.language import not_english
from doro_nlu.parser import Parse, parse
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
                text=message.text,
                task=reply.task,
                tokens=reply.tokens,
                labels=reply.labels,
                graph=reply.graph,
                readings=reply.readings,
                reason=reply.reason,
                confidence=reply.confidence,
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
        understood = (self._cached if caption else self._understand)([text])[0]
        tagged, result = understood.tagged, understood.parse
        if result.second and result.graph and not caption:
            result = Parse(None, [], "", 0.0, two_targets(result.graph.name, result.second))
        return ParseReply(
            text=text,
            task="" if caption else result.task,
            tokens=list(tagged.tokens),
            labels=list(tagged.labels),
            graph=result.graph,
            readings=list(result.readings),
            reason=result.reason,
            confidence=result.confidence,
        )

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
        reason = not_english(tagged.tokens, self._tagger.knows)
        if reason:
            return Understood(text, tagged, Parse(None, [], "", 0.0, reason))
        result = parse(tagged, text)
        if result.graph and result.object_probability < self._settings.min_object_probability:
            reason = (
                f"it is not clear what is meant by '{result.graph.name}' in '{text.strip()[:80]}':"
                " say it in other words"
            )
            result = Parse(None, [], "", 0.0, reason)
        return Understood(text, tagged, result)


def two_targets(first: str, second: str) -> str:
    """Return the reason for an instruction with two objects: one is fetched at a time."""
    return f"two targets were named, '{first}' and '{second[:80]}': ask for one at a time"


def canonical(graph: ObjectGraph) -> ObjectGraph:
    """Return a graph with canonical names and values."""
    return ObjectGraph(
        name=canonical_name(graph.name),
        attributes={kind: canonical_value(value) for kind, value in graph.attributes.items()},
        relations=[Relation(item.type, canonical(item.target)) for item in graph.relations],
    )


def _graph_box(box: CaptionedBox, graph: ObjectGraph) -> GraphBox:
    return GraphBox(
        box_px=box.box_px,
        score=box.score,
        graph=graph,
        caption=box.caption,
        classes=box.classes,
    )
