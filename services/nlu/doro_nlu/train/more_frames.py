"""Frames for training only: what people write to and say to a robot, beyond the base frames.

None of these is a held-out frame; the held-out ones are every fifth of ``frames.py``.
"""

from __future__ import annotations

from doro_nlu.train.more_short_frames import ANSWERS, CAPTIONS, NOTHING

_INSTRUCTIONS = tuple("""
<go> , <go> , <verb> <ref> .
<go> . <go> . <verb> <ref> and <tail> .
<go> and <verb> <ref> and <put2> it <dest> .
<go> and <verb> <ref> . then <go> and <put2> it <dest> .
<go> , <verb> <ref> , and <put2> it <dest> .
<go> to <verb> <ref>
<voc> <go> and <verb> <ref>
<side> , <side> , <verb> <ref> , <side> .
<side> and then <verb> <obj> and <side>
<side> to <verb> <obj> , <side> .
<verb> <ref> and <side>
<verb> <ref> , <side> , <go>
<verb> <ref> while <doingside>
with <obj> in hand , <tail>
<verb> <keep><from> and <put2> <again> <dest>
<verb> <keep> , <go> , and <put2> <again> <dest>
<verb> <keep><from> , <go> , <put2> <again> <dest> and <side>
<go> , <verb> <keep> and <put2> <again> <dest> .
<verb> <ref> . bring it to me in <plain>
<verb> <ref> and bring it to <plain> . <put2> it <dest> .
<verb> <ref> and carry it over to <plain>
<pol> <verb> <ref> and give it to <person>
<pol> <bring> <obj> , it is <rel>
<pol> <bring> <obj> it is <rel>
<bring> <obj> , it 's <rel> . <tail>
<verb> <obj> . it should be <rel>
<verb> <obj> . you will find it <rel>
<verb> <obj> , you can find it <rel>
<lost> <obj> , i think it is <rel>
<lost> <obj> , maybe it 's <rel> , can you check
<pol> <put> <dest> <obj>
<pol> <bring> <todest> <obj>
<pol> take <todest> <obj><from>
<put> <obj> <todest> , <todest>
take <obj> <todest> <dest>
bring <obj> <todest> <dest>
<pol> carry <obj><from> and <put2> it <dest>
<pol> transport <obj><from> <todest>
<pol> move <obj> <todest>
<pol> move <obj> <dest>
<cook> <obj> and <put2> it <dest>
<cook> <obj> <appliance>
<cook> <obj> <appliance> and <put2> it <dest>
<cook> <obj> , then <put2> it <dest> .
<put> <cooked> {O <name>} <dest>
<pol> <put> a <cooked> {O <name>} <dest>
<put> the <cooked> <col> {O <name>} <dest> .
<put> two <cooked> {O <names>} <dest>
<verb> the <cooked> {O <name>}<from>
<put> <obj> <dest> after <cooking> it
take <obj> , <cook> it <appliance> , and <put2> it <dest> .
<verb> <obj><from> , <cook> it <appliance> , <tail>
<verb> <obj> and <cook> it <appliance>
cut <obj> with a knife and <put2> a slice <dest>
<act> <ref> , <tail>
<act> <obj> with <plain>
<act> <ref> and then <tail>
<put> <ref:on> <dest> .
<voc> <put> <ref:on> <dest> please
<go> and <put> <ref:on> <dest>
<pol> <put> <ref:on> <todest>
pull <obj> {A out of} <rel:A>
<part> <obj> <particle>
<part> <obj> <particle> and <put2> it <dest>
<pol> <part> <obj> <particle><from>
<go> , <part> <obj> <particle><from> .
<part> <particle> <ref>
<front> is <obj> . <verb> it and <tail> .
<front> are <plurals> , <verb> them
<front> lies <obj> , <pol> <verb> it
<front> you can see <obj> , <verb> it <todest>
<front> i left <obj> , <bring> it
<front> <pol> get <obj> <todest>
<front> , look for <obj> and <tail>
<front> , <front> , <verb> <obj>
{A inside} <rel:A> there is <obj> that i need
{A from} <rel:A> <pol> , <bring> <obj>
{A from} <rel:A> , <pol> <verb> <obj> .
{P on} <rel:P> there should be <obj> ; <verb> it
{A in} <rel:A> you see <obj> ; <verb> it
<verb> <obj> , which is <rel>
<verb> <obj> that is <rel> and <rel>
<verb> <obj> <rel> , not <notrel>
<verb> <obj> <rel> , not the one <notrel>
not <wrong2> , <verb> <obj>
don't <verb0> <wrong2> , <verb> <obj> <rel>
do not <verb0> <wrong2> . <verb> <ref> instead .
instead of <wrong2> , <verb> <ref>
<verb> <ref> rather than <wrong2>
<verb> <ref> , but leave <wrong2>
<verb> <ref> without touching <wrong2>
<verb> <obj> , i mean the <col> one
<verb> <obj> , sorry , the <col> one <rel>
<verb> <wrong2> , sorry , i mean <ref>
<verb> <wrong2> , wait , no , <ref>
<verb> <wrong2> , er no , <obj>
uh <verb> <ref>
um , <pol> <verb> <ref> uh please
<verb> uh <ref>
<verb> the the {O <name>} <rel>
ok so <verb> <ref>
well <verb> <ref> you know
so <pol> <verb> <ref> okay
<voc> i really need you to <bring> <ref>
<voc> i am <state> , <bring> <ref>
i am <state> . <pol> <bring> <ref>
<lost> <ref> . <pol> <verb0> it
<voc> <where> <ref>
<where> <obj> ? <verb> it
<where> <obj> ? i left it <rel> .
do you know where <obj> is ?
do you know if <obj> is <rel> ?
can you tell me if there is <obj> <rel> ?
check if there is <obj> <rel>
check whether <obj> is <rel>
see if you can find <ref>
go find <ref>
go and find <ref> for <person>
go get <ref>
try to find <ref> before you <go>
help me find <ref>
show <person> where <ref> is
show me what <obj> <rel> looks like
is there <obj> ?
are there <plurals> <rel> ?
i think <obj> is <rel> , <verb> it
<set> . <verb> the <col> one
<set> . <verb> the <nth> one <rel>
<set> , <verb> the one <rel>
of <setof> , <verb> the <col> one
<verb> the <nth> of <setof>
<verb> the <col> one of <setof>
<verb> the <nth> {O <name>} <rel>
<verb> the <nth> <col> {O <name>} <ego>
<verb> the {O <name>} <ego> <rel>
<verb> the {O <name>} that is <ego>
<verb> the <adj> {O <name>} <ego>
<verb> {O <name>} number two <rel>
<verb> the {O <name>} , it is <col>
<verb> the {O <name>} . it is <col> and <rel>
<verb> the {O <name>} . it is made of <mat>
<verb> the <adj> , <col> {O <name>}
<verb> the <col> and <col> {O <name>} <rel>
<verb> the <mat> {O <name>} with <wpart>
<verb> the {O <name>} with <wpart> <rel>
<verb> the {O <name>} that has <wpart>
<verb> the <col2> {O <name>} and the <col3> {O <name2>}
<verb> the <col> {O <name>} and {O <name2>} <rel>
<verb> a {O <name>} , a {O <name2>} and a {O <name3>}
<verb> a {O <name>} and a {O <name2>} <rel>
<put> the {O <name>} and the {O <name2>} <dest>
<put> a {O <name>} with a {O <name2>} inside <dest>
<verb> the {O <name>} <inverse>
<pol> <bring> the {O <name>} <inverse>
<verb> the <col> {O <name>} <inverse> <rel>
<go> and <verb> the {O <name>} <inverse> .
<put> the {O <name>} <inverse> <dest>
<verb> the {O <name>} {P on} the <samecol> {R <place>}
<verb> the <samecol> {O <name>} {P on} the <samecol> {R <place>}
<verb> the <samecol> {O <name>} {N next to} the <samecol> {R <place>} {A in} the {R <room>}
<verb> <obj> {A from} <rel:A> {A in} the {R <room>}
<verb> <obj> among <setof>
<bring> <person> <obj> <rel>
give <person> <obj> <rel>
<verb> something to <use>
<verb> what is <rel>
<verb> whatever is <rel> and <tail>
<verb> everything <rel>
hand over <ref> to <person>
pass <obj> to <person>
<obj> , please
<obj> <rel> please
<obj> , the <col> one
<obj> <todest>
<obj> <todest> please
<obj><from> <todest>
the {O <name>} i want is <rel>
the {O <name>} that i need is <col> and <rel>
the {O <name>} i am looking for is <col>
what i want is <ref>
all i need is <ref>
it is <obj> that i want
you have to <verb> <ref>
you must <verb> <ref> and <tail>
your task is to <verb> <ref>
i order you to <verb> <ref>
be so kind and <verb> <ref>
if there is <obj> <rel> , <verb> it
if you see <obj> , <verb> it
when you are in <plain> , <verb> <ref>
after that , <verb> <ref>
finally <verb> <ref>
begin by <verbing> <ref>
start with <verbing> <obj> and <tail>
i want to see you <verbing0> <ref>
<verbing> <ref>
<putting> <obj> <dest>
to <verb> <obj> and <put2> it <dest>
to <put> <obj> <dest>
""".strip().splitlines())  # fmt: skip

MORE_FRAMES = {
    "instruction": _INSTRUCTIONS,
    "caption": CAPTIONS,
    "answer": ANSWERS,
    "nothing": NOTHING,
}
