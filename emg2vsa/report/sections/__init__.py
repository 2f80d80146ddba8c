"""The sections of the report, one or two of a subject in a file; this tuple is the only list of them.

A section gives, each as a function of the results:

``quantities``  pairs (key, value) for results.json and numbers.tex. Keys are flat, and end in the unit of the value.
``tables``      each ``Table`` is written as CSV and LaTeX. Its rows map the key of every column to a value.
``drawings``    figures, drawn inside ``figures.canvas.style()``.
``words``       more names for the text, for what a template should not compute.
``text``        the Jinja2 template of the section's prose, below at most three sentences before each table.

A text may use: ``q`` (every quantity by its key, as ``q['fit.used']``), ``study``, ``people``, ``runs`` (the parts of
``StudyResults``), its own ``words``, and the functions ``figure(name)`` and ``table(name)`` (seen at once),
``folded(name, summary)`` (a table, or a figure of lesser use), ``has(name)`` (whether there is such a table) and
``why_absent(stage)``. Filters: ``number``, ``bounded``, ``p``, ``percent``, ``signed``, ``count``, ``listed``,
``bullets``. Tables are numbered in the order in which the texts show them; a table that no text shows is written to its
files alone. Text is escaped, minus and percent are set in one way; a name that is not there is an error.

Quantities of all sections are computed first, so that tables and texts of one may use those of another. The
order of this tuple is the order of the page. A new statistic is computed by its stage (or by the arithmetic beneath)
and shown by one section: two files. A new section is one file and one line here.
"""

from __future__ import annotations

from emg2vsa.report.section import Section
from emg2vsa.report.sections.actuators import ACTUATORS, FACTORS
from emg2vsa.report.sections.area import AREA
from emg2vsa.report.sections.claims import CLAIMS
from emg2vsa.report.sections.curves import CURVES
from emg2vsa.report.sections.fits import FITS
from emg2vsa.report.sections.hypotheses import HYPOTHESES
from emg2vsa.report.sections.kappa import KAPPA
from emg2vsa.report.sections.participants import PARTICIPANTS
from emg2vsa.report.sections.plates import PLATES
from emg2vsa.report.sections.profiles import PROFILES, SCHEDULES
from emg2vsa.report.sections.provenance import GLOSSARY, METHODS, PROVENANCE
from emg2vsa.report.sections.rates import RATES
from emg2vsa.report.sections.registration import REGISTRATION
from emg2vsa.report.sections.rig_runs import RUNS
from emg2vsa.report.sections.robustness import ROBUSTNESS
from emg2vsa.report.sections.stiffness import STIFFNESS
from emg2vsa.report.sections.vision import VISION

SECTIONS: tuple[Section, ...] = (
    CLAIMS, ROBUSTNESS, PARTICIPANTS, FITS, HYPOTHESES, CURVES, PROFILES, SCHEDULES, PLATES, RUNS, AREA, VISION, RATES,
    FACTORS, ACTUATORS, STIFFNESS, KAPPA, METHODS, GLOSSARY, REGISTRATION, PROVENANCE,
)  # fmt: skip
