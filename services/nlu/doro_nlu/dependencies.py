"""Dependencies to labels: the second front end of the parser (the paper's future work).

A dependency tree is read into the same BIO labels that a tagger gives, by the rules of the
annotation guide, and with each label goes the noun that the tree hangs it on. From there on the
parser is the same; the tree's attachment is the first reading.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

from doro_nlu import dependency_words as w
from doro_nlu.conllu import Dependencies, Word
from doro_nlu.tagger import Tagged

SURE = 1.0
"""A label read from a tree has no probability of its own: the tree is taken as it is."""


class Labelled(NamedTuple):
    """A sentence as a tagger would give it, and what hangs where.

    ``heads``: by the first token of a label's span, the head token of the noun it belongs to.
    """

    tagged: Tagged
    heads: dict[int, int]


def label(sentence: Dependencies) -> Labelled:
    """Return the labels of a dependency-parsed sentence."""
    return _Labeller(sentence.words).run()


class _Labeller:
    """Labels one sentence, from the target outwards."""

    def __init__(self, words: Sequence[Word]) -> None:
        self.words = words
        self.below: list[list[int]] = [[] for _ in words]
        for index, word in enumerate(words):
            if word.head >= 0:
                self.below[word.head].append(index)
        self.labels = ["O"] * len(words)
        self.heads: dict[int, int] = {}
        self.done: set[int] = set()

    def run(self) -> Labelled:
        root = next(index for index, word in enumerate(self.words) if word.head < 0)
        target, verb = self._target(root)
        if target is not None:
            self._noun(target, "object")
            for other in self._kids(target, "conj"):
                if self.words[other].upos in w.NOUNS:
                    self._noun(other, "object")
            if verb is not None:
                self._around(verb, target)
        words = [word.form for word in self.words]
        return Labelled(Tagged(words, self.labels, [SURE] * len(words)), self.heads)

    # -- the target -----------------------------------------------------------------------

    def _target(self, root: int) -> tuple[int | None, int | None]:
        """Return the target's head noun and the predicate that takes it."""
        if self.words[root].upos in w.NOUNS and not self._kids(root, "cop", "nsubj"):
            return root, None
        for verb in self._clauses(root):
            found = self._taken(verb)
            if found is not None:
                return found, verb
        return None, None

    def _clauses(self, root: int) -> Iterable[int]:
        """Yield the predicates of the main request, the wanted one before the wrapping one.

        "I would like you to bring", "could you try to find": the inner clause is the request.
        "Go there and bring": one after the other.
        """
        inner = self._kids(root, "xcomp", "ccomp", "advcl", "csubj")
        wraps = self.words[root].lemma in w.WRAPPERS
        first = [one for one in inner if wraps and self.words[one].upos == "VERB"]
        for one in first:
            yield from self._clauses(one)
        yield root
        for one in self._kids(root, "conj", "parataxis", "list"):
            if self.words[one].upos in ("VERB", "AUX", *w.NOUNS, "ADJ", "ADV"):
                yield from self._clauses(one)

    def _taken(self, verb: int) -> int | None:
        lemma = self.words[verb].lemma
        nouns = [one for one in self._kids(verb, "obj") if self._names(one)]
        if lemma in w.WANTS and self._kids(verb, "xcomp", "ccomp"):
            nouns = []
        nouns += [
            one
            for one in self._kids(verb, "obl", "nmod")
            if self._names(one) and self._case(one) in w.SOUGHT.get(lemma, ())
        ]
        described = self._kids(verb, "cop", "expl") or lemma in ("be", "where")
        if described or self._kids(verb, "nsubj:pass"):
            nouns += [one for one in self._kids(verb, "nsubj") if self._names(one)]
        return nouns[0] if nouns else None

    def _names(self, index: int) -> bool:
        return self.words[index].upos in w.NOUNS and self.words[index].form not in w.ONES

    # -- noun phrases ---------------------------------------------------------------------

    def _noun(self, head: int, kind: str) -> None:
        """Label a noun phrase: the noun, its colours and materials, its landmarks."""
        if head in self.done:
            return
        self.done.add(head)
        span = self._span(head)
        self._put(span, kind)
        inside = set(range(span[0], span[-1] + 1))
        for one in self.below[head]:
            relation = self.words[one].deprel
            if relation in ("amod", "compound", "nmod") and one not in inside:
                self._value(one, head)
            if relation in ("nmod", "obl"):
                self._landmark(one, head)
            elif relation in ("acl", "appos", "amod", "advmod"):
                self._clause(one, head)
        measured = [one for one in inside if one != head and self.words[one].deprel == "nmod"]
        for one in measured:
            for below in self._kids(one, "nmod"):
                self._landmark(below, head)

    def _span(self, head: int) -> list[int]:
        """Return the tokens of a noun's name: compounds, and "glass of water"."""
        first = head
        while first > 0 and self._is_part_of_name(first - 1, head):
            first -= 1
        last = head
        for one in self._kids(head, "flat", "compound", "goeswith"):
            last = max(last, one) if one == last + 1 else last
        for one in self._kids(head, "nmod"):
            of = self._kids(one, "case")
            plain = not self._kids(one, "det")
            if self.words[head].lemma in w.CONTAINERS and of == [last + 1] and plain:
                last = one if self.words[of[0]].form == "of" else last
        return list(range(first, last + 1))

    def _is_part_of_name(self, index: int, head: int) -> bool:
        word = self.words[index]
        named = word.deprel in ("compound", "flat") and self._leads_to(index, head)
        hyphen = word.form == "-" and index > 0 and self._is_part_of_name(index - 1, head)
        if not named and not hyphen:
            return False
        pair = f"{word.form} {self.words[index + 1].form}"
        return word.form not in w.MATERIALS or pair in w.LEXICAL

    def _leads_to(self, index: int, head: int) -> bool:
        above = self.words[index].head
        return above == head or (above >= 0 and self.words[above].head == head)

    def _value(self, index: int, noun: int) -> None:
        """Label a colour or material, with its shade, and those joined to it."""
        word = self.words[index]
        kind = w.kind_of_value(word.form, is_compound=word.deprel in ("compound", "nmod"))
        if kind and self.labels[index] == "O":
            first = index
            while first > 0 and self.words[first - 1].form in w.SHADES:
                first -= 1
            shades = [one for one in range(first, index) if self._is_below(one, (index, noun))]
            self._put([*(shades if kind == "color" else []), index], kind)
            self.heads[shades[0] if shades and kind == "color" else index] = noun
        for one in self._kids(index, "conj"):
            self._value(one, noun)

    def _is_below(self, index: int, above: Sequence[int]) -> bool:
        return self.words[index].head in above

    # -- relations ------------------------------------------------------------------------

    def _around(self, verb: int, target: int) -> None:
        """Label what the predicate says of where the target is: "from the sink", "it is on it"."""
        word = self.words[verb]
        nouns = self._kids(verb, "obl", "nmod", "advmod")
        if word.upos in w.NOUNS and self._kids(verb, "cop") and verb != target:
            nouns = [verb, *nouns]
        elif word.upos == "ADJ":
            self._clause(verb, target)
        for one in nouns:
            fronted = one < verb and one < target
            case = self._case(one)
            places = one == verb or word.lemma in w.FETCH | w.PLACED
            from_ = case.split(" ")[0] in ("from", "off", "out")
            if one != target and (fronted or from_ or places) and case not in w.TOWARDS:
                self._landmark(one, target)

    def _landmark(self, index: int, noun: int) -> None:
        """Label a noun phrase that says where another one is: connector and landmark."""
        cases = self._case_tokens(index)
        case = " ".join(self.words[one].form for one in cases)
        if self.words[index].form in w.THIRD or self.words[index].upos not in w.NOUNS:
            return
        light = self._light(index, cases)
        if light is not None:
            cases, index = light
            case = " ".join(self.words[one].form for one in cases)
        kind = w.kind_of_relation(case)
        if case.split(" ")[0] in w.COMPANIONS:
            if self.words[index].lemma not in w.PARTS:
                self._contents(index, noun)
            else:
                self.done.add(index)
                for one in self._kids(index, "amod"):
                    self._value(one, noun)
        elif kind and cases:
            self._put(cases, kind)
            self.heads[cases[0]] = noun
            self._noun(index, "related")
            for one in self._kids(index, "conj"):
                if self.words[one].upos in w.NOUNS:
                    self._noun(one, "related")

    def _contents(self, index: int, noun: int) -> None:
        """Label "with the sponge on it": the landmark, and the connector before "it"."""
        self.heads[index] = noun
        for one in [index, *self._kids(index, "conj")]:
            self._noun(one, "related")
            self.heads[self._span(one)[0]] = noun
            for below in [*self._kids(one, "nmod", "obl", "advmod"), *self._kids(one, "acl")]:
                self._stranded(below)

    def _stranded(self, index: int) -> None:
        """Label a connector whose landmark is "it", or that stands alone ("inside")."""
        cases = self._case_tokens(index) if self.words[index].form in w.THIRD else [index]
        kind = w.kind_of_relation(" ".join(self.words[one].form for one in cases))
        if kind and cases and self.words[cases[-1]].upos in ("ADP", "ADV"):
            self._put(cases, kind)

    def _light(self, index: int, cases: list[int]) -> tuple[list[int], int] | None:
        """Read "on top of the table", "in the corner of the room": the part joins the connector."""
        if not cases or self.words[index].lemma not in w.LIGHT:
            return None
        for one in self._kids(index, "nmod"):
            of = self._case_tokens(one)
            if of and self.words[of[0]].form in ("of", "to"):
                return list(range(cases[0], of[-1] + 1)), one
        return None

    def _clause(self, index: int, noun: int) -> None:
        """Read a clause on a noun: "that is red", "lying on the desk", "made of wood"."""
        word = self.words[index]
        if word.upos in w.NOUNS and self._case_tokens(index):
            self._landmark(index, noun)
        if word.form in w.CLOSE:
            for one in self._kids(index, "obl", "nmod"):
                cases = [index, *self._case_tokens(one)]
                if cases == list(range(cases[0], cases[-1] + 1)):
                    self._put(cases, "is-near")
                    self.heads[index] = noun
                    self._noun(one, "related")
            return
        self._value(index, noun)
        for one in self._kids(index, "xcomp", "acomp", "attr") if word.lemma == "be" else []:
            self._clause(one, noun)
        for one in self._kids(index, "obj"):
            if word.lemma in w.HOLDING:
                self._contents(one, noun)
        carried = [one for one in self._kids(index, "nsubj") if self._names(one)]
        alone = self._alone(index)
        if carried and alone is not None and word.deprel == "acl":
            self._noun(carried[0], "related")
            self.heads[self._span(carried[0])[0]] = noun
            self._put([alone], w.kind_of_relation(self.words[alone].form))
            return
        for one in self._kids(index, "obl", "nmod"):
            if word.lemma == "make" and self._case(one) == "of":
                self._value(one, noun)
            else:
                self._landmark(one, noun)
        for one in self._kids(index, "conj"):
            self._clause(one, noun)

    def _alone(self, index: int) -> int | None:
        """Return the preposition that ends a relative clause: "that the lamp is on"."""
        for one in [index, *self._kids(index, "obl", "advmod", "case", "compound")]:
            near = w.kind_of_relation(self.words[one].form)
            if near and not self._kids(one, "nmod") and self.words[one].upos in ("ADP", "ADV"):
                return one
            for below in self._kids(one, "case"):
                if self.words[one].upos == "PRON" and w.kind_of_relation(self.words[below].form):
                    return below
        return None

    # -- helpers --------------------------------------------------------------------------

    def _kids(self, index: int, *relations: str) -> list[int]:
        return [one for one in self.below[index] if self.words[one].deprel in relations]

    def _case_tokens(self, index: int) -> list[int]:
        """Return the tokens of a noun's preposition, those fixed to it included, in order."""
        found: list[int] = []
        for one in self._kids(index, "case"):
            found += [one, *self._kids(one, "fixed", "case", "obl"), *self._kids(one, "advmod")]
        plain = [one for one in sorted(set(found)) if self.words[one].form not in w.ADVERBS]
        whole = bool(plain) and plain == list(range(plain[0], plain[-1] + 1))
        return plain if whole else plain[:1]

    def _case(self, index: int) -> str:
        return " ".join(self.words[one].form for one in self._case_tokens(index))

    def _put(self, tokens: Sequence[int], kind: str) -> None:
        for place, token in enumerate(tokens):
            self.labels[token] = f"{'I' if place else 'B'}-{kind}"
