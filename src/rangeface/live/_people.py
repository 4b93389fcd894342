"""Who has been here: people remembered for a while, with or without a name."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass, replace

from rangeface.gallery import stack
from rangeface.recognizer import FaceRecognizer
from rangeface.types import Template


@dataclass(frozen=True, eq=False)
class Person:
    """Somebody who has been seen.

    Parameters
    ----------
    number : int
        From 1.
    subject : str, optional
        Name, if enrolled.
    template : Template, optional
        How they looked, for those without a name.
    first_s, last_s : float
        When they were first and last seen.
    visits : int
        How often they came.
    """

    number: int
    subject: str | None
    template: Template | None
    first_s: float
    last_s: float
    visits: int = 1


class People:
    """Remembers everybody who was seen, and knows them again.

    Parameters
    ----------
    recognizer : FaceRecognizer
        Its scores compare templates.
    threshold : callable
        Number of people who are compared → score from which two templates are of one person.
    remember_s : float
        So long after they were last seen people without a name are known again.
    """

    def __init__(
        self, recognizer: FaceRecognizer, *, threshold: Callable[[int], float], remember_s: float
    ) -> None:
        self._recognizer = recognizer
        self.threshold = threshold
        self._remember_s = remember_s
        self._people: dict[int, Person] = {}
        self._count = 0

    def __len__(self) -> int:
        return self._count

    def everybody(self) -> tuple[Person, ...]:
        """All who are remembered, in the order of their first visit."""
        return tuple(self._people.values())

    def meet(
        self, subject: str | None, template: Template | None, time_s: float, present: set[int]
    ) -> Person:
        """The person of a track: known again, or new. Nobody is present twice."""
        self._forget(time_s)
        known = self._known(subject, template, present)
        if known is None:
            self._count += 1
            known = Person(self._count, subject, template, time_s, time_s)
        else:
            known = replace(known, visits=known.visits + 1, last_s=time_s)
        self._people[known.number] = known
        return known

    def seen(self, number: int, template: Template | None, time_s: float) -> None:
        """Bring a present person's memory up to date."""
        if number in self._people:
            person = self._people[number]
            self._people[number] = replace(
                person, last_s=time_s, template=template or person.template
            )

    def name(self, number: int, subject: str, time_s: float) -> Person:
        """Somebody present turns out to have a name: who is that?"""
        before = self._people.get(number)
        if before is not None and before.subject == subject:
            return before
        if before is None or before.subject is not None:  # a name instead of another one
            return self.meet(subject, None, time_s, set())
        known = self._known(subject, None, set())
        if known is None:
            known = replace(before, subject=subject)
        else:  # two numbers were one person
            known = replace(known, visits=known.visits + 1, last_s=time_s)
            del self._people[number]
            self._count -= 1
        self._people[known.number] = known
        return known

    def forget_names(self, enrolled: Collection[str]) -> None:
        """Forget those with a name who are not enrolled any more."""
        self._people = {
            number: person for number, person in self._people.items()
            if person.subject is None or person.subject in enrolled
        }  # fmt: skip

    def _known(
        self, subject: str | None, template: Template | None, present: set[int]
    ) -> Person | None:
        others = [p for p in self._people.values() if p.number not in present]
        if subject is not None:
            return next((p for p in others if p.subject == subject), None)
        nameless = {str(p.number): p.template for p in others if p.subject is None and p.template}
        if template is None or not nameless:
            return None
        references = stack(nameless.items(), template.fingerprint)
        scores = self._recognizer.scores(template, references)
        best = int(scores.argmax())
        if scores[best] < self.threshold(len(nameless)):
            return None
        return self._people[int(references.subjects[best])]

    def _forget(self, time_s: float) -> None:
        self._people = {
            number: person for number, person in self._people.items()
            if person.subject is not None or time_s - person.last_s <= self._remember_s
        }  # fmt: skip
