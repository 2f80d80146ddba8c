"""Who is told what goes on at the rig, and who is asked: somebody at a terminal or in a notebook, or nobody."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from emg2vsa.errors import SettingError

Say = Callable[[str], None]


def _unheard(line: str) -> None:
    """Nobody listens."""


@dataclass(frozen=True)
class Person:
    """What is done with each line, and how a question is put. `NOBODY`, the default of every function, hears nothing
    and is not asked: all questions count as answered with yes, as with ``--yes``.

    say : what goes on, or was found. hint : advice. warn : what must not be overlooked. note : progress.
    ask : puts a question, and gives the words of the answer; None where nobody can answer. ``print`` and ``input`` do.

    >>> from emg2vsa import rig
    >>> me = rig.Person(say=print, warn=print, ask=input)
    """

    say: Say = _unheard
    hint: Say = _unheard
    warn: Say = _unheard
    note: Say = _unheard
    ask: Callable[[str], str | None] | None = None

    def answer(self, question: str) -> str:
        """The words of the answer; "" where nobody is asked. SettingError where nobody can answer."""
        if self.ask is None:
            return ""
        if (said := self.ask(question)) is None:
            do = "Run it in a terminal, or add --yes."
            raise SettingError("standard input", wanted="an answer", found="the end of the input", do=do)
        return said

    def agrees(self, question: str) -> bool:
        """Yes, or nobody is asked. Raises as `answer`."""
        return self.ask is None or self.answer(f"{question} [y/N] ").lower() in ("y", "yes")


NOBODY = Person()
