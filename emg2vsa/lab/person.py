"""Who is told what goes on at the rig, and who is asked: somebody at a terminal or in a notebook, or nobody."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass

from emg2vsa.errors import SettingError

Say = Callable[[str], None]
TRIES = 20
"""Wrong answers to one question, after which a program that answers is taken for one that never will."""


def _unheard(line: str) -> None:
    """Nobody listens."""


@dataclass(frozen=True)
class Person:
    """What is done with each line, and how a question is put. `NOBODY`, the default of every function, hears nothing
    and answers nothing: what needs an answer is refused, before anything moves.

    say : what goes on, or was found. hint : advice. warn : what must not be overlooked. note : progress.
    ask : puts a question, and gives the words of the answer; None where nobody can answer. ``print`` and ``input`` do.
    yes : questions count as answered with yes, and are not put, as with ``--yes``.

    >>> from emg2vsa import rig
    >>> me = rig.Person(say=print, warn=print, ask=input)
    """

    say: Say = _unheard
    hint: Say = _unheard
    warn: Say = _unheard
    note: Say = _unheard
    ask: Callable[[str], str | None] | None = None
    yes: bool = False

    def answer(self, question: str, among: Collection[str] = ()) -> str:
        """The words of the answer, in lower case where they must be ``among`` others; "" where nobody is asked.
        SettingError where nobody can answer, or nobody does so in `TRIES`."""
        if self.yes:
            return ""
        if self.ask is None:
            do = "Give a Person with ask=input, or with yes=True where no question is wanted."
            raise SettingError(
                "person", wanted=f"an answer to {question.strip()!r}", found="nobody who is asked", do=do
            )
        for _ in range(TRIES):
            if (said := self.ask(question)) is None:
                do = "Run it in a terminal, or add --yes."
                raise SettingError("standard input", wanted="an answer", found="the end of the input", do=do)
            if not among or said.strip().lower() in among:
                return said.strip().lower() if among else said
        listed = ", ".join(repr(each) for each in among)
        do = "Answer with one of them."
        raise SettingError("standard input", wanted=f"one of {listed}", found=repr(said), do=do)

    def agrees(self, question: str) -> bool:
        """Yes, or nobody is asked. Raises as `answer`."""
        return self.yes or self.answer(f"{question} [y/N] ").strip().lower() in ("y", "yes")


NOBODY = Person()
