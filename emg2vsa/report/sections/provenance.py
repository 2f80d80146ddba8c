"""Where the numbers come from: methods as a journal prints them, with the works that they cite; terms; provenance."""

from __future__ import annotations

from collections.abc import Sequence

from emg2vsa.extraction import Trials
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.methods import methods
from emg2vsa.report.numbers import Items
from emg2vsa.report.references import Work, bibtex, cited, works_in
from emg2vsa.report.section import Quantities, Section
from emg2vsa.report.wording import unwrapped

_FILTER_NOTES = ("NYQUIST RULE", "EMG band-pass", "EMG high-pass", "EMG envelope", "force low-pass", "delays:")


def filters_as_run(trials: Sequence[Trials]) -> list[str]:
    """What the filters did to these recordings, as their notes say: true edges and delays."""
    return list(dict.fromkeys(note for t in trials for note in t.notes if note.startswith(_FILTER_NOTES)))


def methods_text(results: StudyResults) -> str:
    """Plain text: headings, paragraphs, references."""
    told, works = _told(results)
    parts = [f"{heading}\n{text}" for heading, text in told]
    parts += ["References\n" + "\n".join(f"{work.text} {work.doi}".rstrip() for work in works)] if works else []
    return "\n\n".join(parts)


def references_bib(results: StudyResults) -> str:
    """The works that the methods cite, as BibTeX."""
    return bibtex(_told(results)[1])


def _told(results: StudyResults) -> tuple[list[tuple[str, str]], list[Work]]:
    told = methods(results)
    return [(heading, cited(text)) for heading, text in told], works_in(text for _, text in told)


def _methods_words(results: StudyResults, q: Quantities) -> dict[str, object]:
    told, works = _told(results)
    return {"told": told, "works": works, "filters": filters_as_run(results.people.trials) if results.people else []}


_METHODS_TEXT = """
<p>The settings that ran gave this text. A paper may print <a href="methods.txt">methods.txt</a> as it stands
{%- if works %}; <a href="references.bib">references.bib</a> has its references{% endif %}.</p>
<details><summary data-file="methods.txt">Read the methods here</summary>
{% for heading, text in told %}
<h3>{{ heading }}</h3>
<p>{{ text }}</p>
{{ filters | bullets if heading == "Signal processing" }}
{% endfor %}
{% if works %}
<h3>References</h3>
<ul>{% for work in works %}<li>{{ work.text }}
{% if work.doi %}<a href="https://doi.org/{{ work.doi }}">doi:{{ work.doi }}</a>{% endif %}</li>{% endfor %}</ul>
{% endif %}
</details>
"""

METHODS = Section("methods", "Methods", _METHODS_TEXT, words=_methods_words)


def _quantities(results: StudyResults) -> Items:
    study = results.study
    yield "study.name", study.name
    yield "study.mode", study.mode
    yield "study.truth_found", results.people is not None and results.people.truth is not None
    yield "study.specimens", len(study.specimens)
    yield "study.failures", len(results.failures)


def _words(results: StudyResults, q: Quantities) -> dict[str, object]:
    return {"provenance": sorted(results.provenance.items())}


_TEXT = """
<p><a href="results.json">results.json</a> holds every number of this page, and <a href="numbers.tex">numbers.tex</a>
the same numbers as LaTeX macros. The folders tables/ and figures/ beside this page hold its tables and figures.</p>
{% if provenance %}
<details><summary>Versions and digests</summary>
<dl>{% for name, value in provenance %}<dt>{{ name }}</dt><dd><code>{{ value }}</code></dd>{% endfor %}</dl>
</details>
{% endif %}
"""

PROVENANCE = Section("provenance", "Provenance", _TEXT, quantities=_quantities, words=_words)

TERMS = tuple(
    tuple(line.split(": ", 1))
    for line in unwrapped("""
a, b: coefficients of the fit v = a + b ln(F / 1 N): a is the co-contraction at 1 N, b its growth when force grows
  e-fold
A_c0: initial contact area, in mm²
adjusted R²: share of variance that a fit explains, corrected for the number of its parameters. It grows with the
  smoothness of the points
α: significance level of a test; in an interpolation, the weight of the softer neighbour
BF₀₁: Bayes factor: how many times better equal means explain the data than different means. Above 3 it supports
  equality, below 1/3 a difference
bin: a force interval, 0.3 N by default; its mean is one point of the fit
CASR: contact area spread rate: contact area gained per newton, in mm²/N
circle, edge, front, hexagon, paper: vision algorithms that measure the contact area: the circle through the outermost
  moving pin (the paper's old algorithm), the fold of the pins' motion, the contact front in every frame, one hexagon
  per moving pin with our laws, and the paper's new algorithm with its own force rule and equations (in paper mode
  with its dense flow too)
cluster: the slopes b of one participant on one specimen
co-contraction: activity of antagonist muscles at the same time; here the sum of their envelopes unless the study says
  otherwise
companion: a test that fits the question better than the paper's test, shown beside it
condition: how the actuator's stiffness is set: high-stiffness (rigid), modular (the human-like profile) or
  constant-min, constant-mean, constant-max
CV: coefficient of variation: standard deviation over mean
design: a condition at an angle
Dunn's test: comparison of pairs by their mean ranks over all groups, with Bonferroni's correction
ε (GG, HF): sphericity of repeated measures, estimated after Greenhouse and Geisser or Huynh and Feldt; 1 means
  spherical
ε²_R: effect size of the Kruskal-Wallis test, 0 to 1
η², η²_G: share of variance between groups; generalised for repeated measures
FDR: false discovery rate: the expected share of false ones among significant tests
g, g_z: Hedges' g: a difference of means over the pooled standard deviation, corrected for small samples. g_z is over
  the standard deviation of paired differences
gap, d′: distance of the two neighbours whose stiffness differs least: difference of mean ln CASR over mountings, in
  standard deviations of a press of one mounting
Hazen's quartiles: quartiles by linear interpolation at (i − 0.5) / n, as MATLAB's boxplot draws them
Holm: correction of p for the number of tests; it keeps the chance of any false rejection below α
ICC: intraclass correlation: share of variance that is due to differences between participants
JZS: prior of the Bayes factor after Jeffreys, Zellner and Siow
κ (kappa): stiffness of a specimen by plate indentation, in N/mm
LSD: Fisher's least significant difference: t tests after an ANOVA without correction for their number
ω², partial ω²: share of the population's variance that a factor explains, without the upward bias of η²; partial:
  beside the scatter within cells alone
profile likelihood: interval of all values of a standard deviation at which the best choice of the other parameters
  fits almost as well
r_rb: rank-biserial correlation: effect size of the Mann-Whitney test, −1 to 1
RMSE: root mean square error
SD, SE: standard deviation of values; standard error of an estimate
slope b: growth of co-contraction when force grows e-fold
specimen: a soft block to press
TOST: two one-sided tests: they show equality within a stated margin
trial, press: the loading phase of one press
verdict: of a press: ok, doubtful, rejected. Of a session: good, usable, repeat, unreadable. Of a claim: holds, refuted,
  not determined
""")
)
"""Terms of the report that a reader may not know, and their meaning; docs/glossary.md has them in the same words."""

_GLOSSARY_TEXT = """
<details><summary>{{ terms | length }} terms of this page</summary>
<dl>{% for term, meaning in terms %}<dt>{{ term }}</dt><dd>{{ meaning }}</dd>{% endfor %}</dl>
</details>
"""

GLOSSARY = Section("glossary", "Glossary", _GLOSSARY_TEXT, words=lambda results, q: {"terms": TERMS})
