"""A section of the report: its numbers, tables, drawings and text, and how the text is filled."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from jinja2 import Environment, StrictUndefined
from markupsafe import Markup

from casr import html
from emg2vsa.claims.claim import Judged
from emg2vsa.report import wording
from emg2vsa.report.drawing import Drawing, shown
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.numbers import Items, Quantity
from emg2vsa.report.table import Table

Quantities = Mapping[str, Quantity]
"""Every number of the report by its key in results.json, those of the other sections included."""


@dataclass(frozen=True)
class PaperTest:
    """What the paper prints of a claim, and what its own test says here; ``here`` names the test and the algorithm."""

    printed: str
    here: str = ""


def of_people(results: StudyResults) -> bool:
    """Whether the study has fits of people's presses."""
    return results.people is not None


def of_runs(results: StudyResults) -> bool:
    """Whether the study has scored runs."""
    return results.runs is not None


@dataclass(frozen=True)
class Section:
    """One section. ``text`` is a Jinja2 template; ``emg2vsa.report.sections`` says what it may ask for."""

    name: str
    "Its address on the page."
    title: str
    text: str
    applies: Callable[[StudyResults], bool] = lambda results: True
    quantities: Callable[[StudyResults], Items | Iterable[tuple[str, Quantity]]] = lambda results: ()
    tables: Callable[[StudyResults, Quantities], Iterable[Table]] = lambda results, q: ()
    drawings: Callable[[StudyResults], Iterable[Drawing]] = lambda results: ()
    words: Callable[[StudyResults, Quantities], Mapping[str, object]] = lambda results, q: {}
    "More that the text may ask for, by name."


@dataclass
class Content:
    """What the sections of one report gave, by name, and how many tables the page has shown so far."""

    quantities: dict[str, Quantity] = field(default_factory=dict)
    tables: dict[str, Table] = field(default_factory=dict)
    drawings: dict[str, Drawing] = field(default_factory=dict)
    judged: Sequence[Judged] = ()
    "Every claim with its verdict."
    summary: list[str] = field(default_factory=list)
    "Sentences of the first section."
    _numbers: dict[str, int] = field(default_factory=dict)

    def table(self, name: str) -> Markup:
        """The table with its number, seen at once: of what nobody may miss. Nothing where there is none, or no row."""
        if name not in self.tables or not self.tables[name].rows:
            return Markup()
        return Markup(self.tables[name].html(self._numbers.setdefault(name, len(self._numbers) + 1)))

    def folded(self, name: str, summary: str) -> Markup:
        """The table with its number and its file, or the figure, folded away under ``summary``; paper shows the file.

        Nothing where this study has no such table or figure, or the table has no rows.
        """
        if name in self.drawings:
            return Markup(html.details(summary, shown(self.drawings[name]), f"figures/{name}.svg"))
        if not (body := self.table(name)):
            return body
        return Markup(html.details(f"Table {self._numbers[name]}. {summary}", body, f"tables/{name}.csv"))

    def figure(self, name: str) -> Markup:
        """The figure, seen at once; nothing where this study has none."""
        return Markup(shown(self.drawings[name])) if name in self.drawings else Markup()


def rendered(section: Section, results: StudyResults, content: Content) -> str:
    """The section as HTML; UndefinedError where its text asks for what there is not."""
    body = _TEMPLATES.from_string(section.text).render(
        q=content.quantities,
        study=results.study,
        people=results.people,
        runs=results.runs,
        table=content.table,
        folded=content.folded,
        figure=content.figure,
        has=lambda name: name in content.tables,
        why_absent=results.why_absent,
        summary=content.summary,
        **section.words(results, content.quantities),
    )
    return html.section(section.name, section.title, body.replace(" %", f"{wording.NO_BREAK}%"))


def _typeset(value: object) -> object:
    """What a template prints; markup is finished already."""
    return wording.typeset(value) if isinstance(value, str) and not isinstance(value, Markup) else value


_TEMPLATES = Environment(
    autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True, finalize=_typeset
)
_PLAIN = (wording.number, wording.bounded, wording.percent, wording.signed, wording.count, wording.listed)
_TEMPLATES.filters |= {plain.__name__: plain for plain in _PLAIN}
_TEMPLATES.filters["p"] = wording.p_text
_TEMPLATES.filters["bullets"] = lambda texts: Markup(html.bullets(map(wording.typeset, texts)))
