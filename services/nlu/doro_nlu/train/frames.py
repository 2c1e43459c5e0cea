"""Sentence frames: what stands around a referring expression.

A frame is a text with slots in angle brackets, filled by :class:`Filler`; all words outside
slots and brackets are O. Every fifth frame of each list is held out: never trained on.
"""

from __future__ import annotations

from doro_nlu.train.more_frames import MORE_FRAMES

HELD_OUT_EVERY = 5

INSTRUCTIONS = tuple("""
<pol> <verb> <ref><end>
<pol> <bring> <ref><end>
<verb> <ref>
<go> and <verb> <ref><end>
<pol> <bring> <obj> {A from} <rel:A><end>
<pick> <obj> up<from><end>
<pol> <verb> <ref> and <tail><end>
<go>, <verb> <ref><end>
<verb> <ref>, then <tail><end>
<verb> <ref> , <tail>
<front> there is <obj>, <tail><end>
<front> there is <ref> . <tail><end>
<pol> <put> <obj> <dest><end>
<front>, <verb> <ref><end>
<front> <verb> <obj><end>
<pol> take <obj> <todest><end>
there is <ref><end>
there is <ref>, <tail><end>
<why> <verb> <ref><end>
<lost> <ref><end>
<where> <ref><where_end>
<ref> please<end>
<put> <obj> {A from} <rel:A> <todest><end>
<put> <obj> {A from} <rel:A> <dest><end>
<pol> turn <obj> <onoff><end>
<pol> switch <obj> <onoff>
<verb> <keep> and <put> <again> <dest><end>
<pol> <verb> <keep><from> . <put> <again> <dest> .
<go> and <verb> <keep> . take <again> <todest> and <tail> .
<inspect> <ref> <light><end>
<inspect> <obj> <light>
<verb> <ref> , <go> , <tail> .
<go> , <go> , <verb> <ref> , <tail> , <go> .
<side> , <put> <obj> <dest> , <side> , <tail> .
<put> <ref:on> <dest> , then <tail><end>
<ref><end>
<pol> <put> <ref:on> <dest><end>
<go> to get <ref><end>
<side> and <verb> <obj><from><end>
<side>, <out> , <tail>
<pol> <verb> <ref><notthis><end>
<pol> remove <obj><from><end>
<act> <ref><end>
<act> <ref> and pick it up<end>
i left <obj> <rel> , <tail>
my <onlyobj> is <rel>, <tail><end>
<obj> is <rel>, <tail><end>
<voc> <pol> <verb> <ref><end>
<pol> <verb> <obj>, the one <rel><end>
<pol> <verb> <obj>, the <col> one<end>
<pol> <verb> the <wrong>, no, <repair><end>
<pol> <verb> <ref> for <person><end>
<pol> search <front> for <obj><end>
check <front> for <obj><end>
<lead> me to <plain> <notrel><end>
i <need> <ref><end>
<pol> <need> <ref> from <rel:A><end>
<verb> <several><end>
<verb> <ref> with your <hand><end>
<verb> <ref> <adv><end>
<go> . <verb> <ref> . <tail> .
<verb> <obj> <ego><end>
<pol> move <obj><from> <todest><end>
<pol> bring <ref> <todest><end>
<ask> <ref> ?
is <obj> <rel> ?
which <onlyobj> is <rel> ?
what is <rel> ?
tell me where <obj> is<end>
<side> , <verb> <ref> , <side><end>
<front> you will find <obj> , <verb> it<end>
<verb> <ref> <before><end>
<pol> <verb> what looks like <obj> <rel><end>
<why> <bring> <obj> <rel><end>
the <onlyobj> should be <rel><end>
<obj> , which is <rel> , <need>s to be cleaned
<pol> <open> <ref><end>
<pol> <open> <obj> , then <tail>
you need to <verb> <ref><end>
now <verb> <ref><end>
next , <verb> <ref> and <tail>
<front> , there should be <obj> . <verb> it<end>
let 's <verb> <ref><end>
<verb> it , the <onlyobj> <rel>
<verb> <ref> if you see it<end>
<set> . <verb> the <col> one
<verb> either <obj> or <obj2><end>
<pol> <verb> <obj> whose color is <col><end>
<pol> <verb> <obj> , <col> and <mat> , <rel><end>
<pol> <verb> the <cols> <onlyobj> <rel><end>
{A out of} <rel:A> , <verb> <obj><end>
<verb> <obj> and <obj2> <rel><end>
the <onlyobj> <rel>
<put> <obj> <dest>
<pol> <put> <obj> <dest>
<put> the <onlyobj> <dest><end>
<go> and <put> <obj> <dest>
<voc> <put> <obj> <todest>
<pol> bring <obj> <todest><end>
<put> <obj> <dest> and <tail>
<put> <obj> <dest><end>
bring <obj> <rel>
<pol> <bring> <obj> <rel><end>
take <obj> <rel><end>
""".strip().splitlines())  # fmt: skip

CAPTIONS = tuple("""
<cap>
<cap> <rel>
<cap> <link> <rel>
<cap><end>
<cap> <rel><end>
<cap> <rel> , <rel>
<cap> <rel> and <rel>
there is <cap> <rel><end>
<cap> <link> <rel> , <rel>
this is <cap><end>
<capbare>
<capbare> <rel>
<cap> <belong>
<cap> <belong> <rel>
a close up of <cap> <rel>
a view of <cap>
<cap> <predicate> <rel>
<cap> is <rel>
<obj> is <col><end>
<obj> is made of <mat><end>
<obj> is <col> and <link> <rel>
two <plurals> <rel>
<cap> , <rel> , <rel> and <rel>
it is <cap> <rel>
<cap> , <link> <rel>
i can see <cap> <rel>
<col> <onlyobj>
<mat> <onlyobj>
<col> <mat> <onlyobj> <rel>
<onlyobj>
<onlyobj> <rel>
the <onlyobj> has a <col> color
<onlyobj> , <col>
<onlyobj> , <col> , <mat>
<onlyobj> ( <col> )
<cap> <doing>
<cap> <doing> <rel>
<cap> <doing> <rel> , <rel>
<colornoun>
<cap> <ego>
""".strip().splitlines())  # fmt: skip

ANSWERS = tuple("""
<no> the <col> one<end>
<no> the one <rel><end>
<no> the <col> one <rel><end>
<no> the <mat> one<end>
<rel>
<col>
<mat>
the one that is <col><end>
i meant <ref><end>
<no> i mean <obj><end>
<no> i want the <col> one
the <nth> one
the <nth> one <rel>
not the <xcol> one
<no> not the <xcol> one , the <col> one
i want the one made of <mat>
<no> <ref><end>
yes , the <col> one please
the <col> <onlyobj>
bring me the one <rel>
the <col> and <mat> one
take the <col> one
it is <rel>
it 's <col>
""".strip().splitlines())  # fmt: skip

NOTHING = tuple("""
<go>
<go> and <go>
<go> , then <go>
<voc> <go>
<pol> <put2> it <dest>
<pol> bring it <todest>
<it>
<it> and <it>
<chat>
<chat>
<foreign>
<foreign>
<foreign2>
<noise>
<voc> <chat>
go <dest>
move <dest>
turn around and face <plain>
the <nth> one
never mind
walk to <plain> and stop <dest>
come with me to <plain>
follow the <person2> to <plain>
""".strip().splitlines())  # fmt: skip

FRAMES = {"instruction": INSTRUCTIONS, "caption": CAPTIONS, "answer": ANSWERS, "nothing": NOTHING}
SHARES = {"instruction": 0.60, "caption": 0.24, "answer": 0.08, "nothing": 0.08}


def frames_of(kind: str, held_out: bool) -> list[str]:
    """Return the frames of a kind, either those trained on or those held out."""
    every = HELD_OUT_EVERY
    trained = [f for index, f in enumerate(FRAMES[kind]) if index % every != every - 1]
    if held_out:
        return [frame for frame in FRAMES[kind][every - 1 :: every] if frame not in trained]
    return trained + list(MORE_FRAMES[kind])
