"""Terms of the report that a reader may not know. docs/glossary.md explains them in the same words."""

from __future__ import annotations

from emg2vsa.report.section import Section

TERMS: tuple[tuple[str, str], ...] = (
    (
        "a, b",
        "coefficients of the fit v = a + b ln(F / 1 N): a is the co-contraction at 1 N, b its growth when force "
        "grows e-fold",
    ),
    ("A_c0", "initial contact area, in mm²"),
    (
        "adjusted R²",
        "share of variance that a fit explains, corrected for the number of its parameters. It grows with the "
        "smoothness of the points",
    ),
    ("α", "significance level of a test; in an interpolation, the weight of the softer neighbour"),
    (
        "BF₀₁",
        "Bayes factor: how many times better equal means explain the data than different means. Above 3 it "
        "supports equality, below 1/3 a difference",
    ),
    ("bin", "a force interval, 0.3 N by default; its mean is one point of the fit"),
    ("CASR", "contact area spread rate: contact area gained per newton, in mm²/N"),
    (
        "circle, edge, front, hexagon, paper",
        "vision algorithms that measure the contact area: the circle through the outermost moving pin (the "
        "paper's old algorithm), the fold of the pins' motion, the contact front in every frame, one hexagon per "
        "moving pin with our laws, and the paper's new algorithm with its own force rule and equations (in paper mode "
        "with its dense flow too)",
    ),
    ("cluster", "the slopes b of one participant on one specimen"),
    (
        "co-contraction",
        "activity of antagonist muscles at the same time; here the sum of their envelopes unless the study says "
        "otherwise",
    ),
    ("companion", "a test that fits the question better than the paper's test, shown beside it"),
    (
        "condition",
        "how the actuator's stiffness is set: high-stiffness (rigid), modular (the human-like profile) or "
        "constant-min, constant-mean, constant-max",
    ),
    ("CV", "coefficient of variation: standard deviation over mean"),
    ("design", "a condition at an angle"),
    ("Dunn's test", "comparison of pairs by their mean ranks over all groups, with Bonferroni's correction"),
    (
        "ε (GG, HF)",
        "sphericity of repeated measures, estimated after Greenhouse and Geisser or Huynh and Feldt; 1 means spherical",
    ),
    ("ε²_R", "effect size of the Kruskal-Wallis test, 0 to 1"),
    ("η², η²_G", "share of variance between groups; generalised for repeated measures"),
    ("FDR", "false discovery rate: the expected share of false ones among significant tests"),
    (
        "g, g_z",
        "Hedges' g: a difference of means over the pooled standard deviation, corrected for small samples. g_z is "
        "over the standard deviation of paired differences",
    ),
    (
        "gap",
        "Hedges' g between the closest neighbours in stiffness: how far two specimens lie apart in standard "
        "deviations of their presses",
    ),
    ("Hazen's quartiles", "quartiles by linear interpolation at (i − 0.5) / n, as MATLAB's boxplot draws them"),
    ("Holm", "correction of p for the number of tests; it keeps the chance of any false rejection below α"),
    ("ICC", "intraclass correlation: share of variance that is due to differences between participants"),
    ("JZS", "prior of the Bayes factor after Jeffreys, Zellner and Siow"),
    ("κ (kappa)", "stiffness of a specimen by plate indentation, in N/mm"),
    ("LSD", "Fisher's least significant difference: t tests after an ANOVA without correction for their number"),
    (
        "ω², partial ω²",
        "share of the population's variance that a factor explains, without the upward bias of η²; partial: beside the "
        "scatter within cells alone",
    ),
    (
        "profile likelihood",
        "interval of all values of a standard deviation at which the best choice of the other parameters fits almost "
        "as well",
    ),
    ("r_rb", "rank-biserial correlation: effect size of the Mann-Whitney test, −1 to 1"),
    ("RMSE", "root mean square error"),
    ("SD, SE", "standard deviation of values; standard error of an estimate"),
    ("slope b", "growth of co-contraction when force grows e-fold"),
    ("specimen", "a soft block to press"),
    ("TOST", "two one-sided tests: they show equality within a stated margin"),
    ("trial, press", "the loading phase of one press"),
    (
        "verdict",
        "of a press: ok, warned, rejected. Of a session: good, usable, repeat, unreadable. Of a claim: holds, "
        "does not hold, cannot be tested here",
    ),
)

_TEXT = """
<details><summary>{{ terms | length }} terms of this page</summary>
<dl>{% for term, meaning in terms %}<dt>{{ term }}</dt><dd>{{ meaning }}</dd>{% endfor %}</dl>
</details>
"""

GLOSSARY = Section("glossary", "Glossary", _TEXT, words=lambda results, q: {"terms": TERMS})
