"""Terms of the report that a reader may not know."""

from __future__ import annotations

from emg2vsa.report.section import Section

_TERMS: tuple[tuple[str, str], ...] = (
    ("a, b", "Coefficients of the fit v = a + b ln F: co-contraction v at 1 N, and its growth per e-fold of force F."),
    ("A_c0", "Initial contact area."),
)

_TEXT = """
<details><summary>{{ terms | length }} terms of this page</summary>
<dl>{% for term, meaning in terms %}<dt>{{ term }}</dt><dd>{{ meaning }}</dd>{% endfor %}</dl>
</details>
"""

GLOSSARY = Section("glossary", "Glossary", _TEXT, words=lambda results, q: {"terms": _TERMS})
