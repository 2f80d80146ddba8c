"""What the forms of AsPredicted and of OSF ask, answered from a study's plan as far as the study says it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from emg2vsa.claims import arithmetic
from emg2vsa.hypotheses import EFFECT_F, EPSILON, RHO
from emg2vsa.registration.plan import Plain
from emg2vsa.statistics.power import power_rm

YOURS = "For the authors to say."


def collected(now: Mapping[str, Any]) -> str:
    """Which data are there, in a sentence."""
    planned, there, runs = now["plan"]["recordings"], now["data"]["recordings"], now["data"]["runs"]
    people = f"{len(there)} of {len(planned)} planned recordings were there." if planned else ""
    return _joined([people, f"{len(runs) or 'No'} measured runs of the rig were there." if runs or not planned else ""])


def answers(content: Plain) -> Plain:
    """The fields ``aspredicted`` and ``osf``: question or heading to its answer."""
    plan, rig = content["plan"], content["plan"]["rig tables"].get("experiment")
    claims = [each for each in content["claims"].values() if each["question"] != arithmetic.QUESTION]
    hypotheses = _joined(f"{each['says'][:1].upper()}{each['says'][1:]}." for each in claims)
    design = _joined([_people(plan), _runs(rig) if rig else ""])
    measured = _joined([
        "Slope b of co-contraction over ln force, by person and specimen." if plan["participants"] else "",
        "Contact area and its spread rate (CASR), by press." if "runs" in plan["tables"] else "",
    ])  # fmt: skip
    analyses, excluded, order = _analyses(plan, claims), _excluded(plan), _order(plan["tables"].get("session"), rig)
    kept = f"Settings of {', '.join(plan['tables'])}, and the digest of the code, are in the registration."
    return {
        "aspredicted": {
            "1) Have any data been collected for this study already?": content["collected"],
            "2) What is the main question or hypothesis?": hypotheses or YOURS,
            "3) Which are the key dependent variables, and how are they measured?": measured or YOURS,
            "4) How many and which conditions are there?": design or YOURS,
            "5) Which analyses exactly will be done?": analyses,
            "6) How are outliers defined, and which observations are excluded?": excluded,
            "7) How many observations will be collected?": _joined([design, _power(plan)]),
            "8) Is there anything else?": f"Order of pressing: {order} {kept}",
        },
        "osf": {
            "Study information": f"{content['title']}. Hypotheses: {hypotheses or YOURS}",
            "Design plan": f"{design} Blinding: {YOURS} Randomization: {order}",
            "Sampling plan": f"Existing data: {content['collected']} Sample size: {design} {_power(plan)} "
            f"Stopping rule: {YOURS}",
            "Variables": f"Manipulated: specimen{', angle and stiffness of the actuator' if rig else ''}. "
            f"Measured: {measured or YOURS}",
            "Analysis plan": f"{analyses} {excluded} Missing data: a person without a specimen is left out of what "
            "needs that specimen. Exploratory: every claim of the report that is not listed here.",
            "Other": kept,
        },
    }  # fmt: skip


def _joined(sentences: Iterable[str]) -> str:
    return " ".join(filter(None, sentences))


def _people(plan: Plain) -> str:
    if not plan["participants"]:
        return ""
    presses = plan["tables"]["window"]["expected_trials"]
    times = f", {presses} times each" if presses else ""
    return f"{len(plan['participants'])} people press {', '.join(plan['specimens'])}{times}."


def _runs(rig: Plain) -> str:
    angles = {name: "/".join(f"{angle:g}" for angle in of) for name, of in rig["angles_deg"].items() if of}
    designs = ", ".join(f"{name} at {of}°" for name, of in angles.items())
    return (
        f"The rig presses {', '.join(rig['specimens'])} ({designs}), {rig['mountings']} mountings of "
        f"{rig['repetitions']} presses each."
    )


def _analyses(plan: Plain, claims: list[Plain]) -> str:
    tables = plan["tables"]
    muscles = sorted({name for own in plan["recordings"].values() for name in own["channels"]["emg"]})
    fit = (
        f"v = a + b ln F is fitted to each press by {tables['fit']['points']} (weights: {tables['fit']['weights']}); v "
        f"is the {tables['cocontraction']['index']} of the envelopes of {', '.join(muscles)}."
    )
    level = max((100 * each["confidence"] for each in claims), default=0)
    judged = (
        f"{len(claims)} claims are judged by intervals of {level:.4g} % and by the margins listed here, so that any "
        f"verdict is false with a chance of {tables['claims']['false_verdict_percent']:g} % at most. People, or "
        "mountings of sensor and specimen, are the units of error."
    )
    vision = f"Presses are scored by the algorithm {tables['runs']['algorithm']}." if "runs" in tables else ""
    return _joined([fit if muscles else "", vision, judged])


def _excluded(plan: Plain) -> str:
    window, use = plan["tables"]["window"], plan["tables"]["hypotheses"]["use"].replace("+", " or ")
    (low, high), shortest, longest = window["force_n"], window["min_duration_s"], window["max_duration_s"]
    return (
        f"A press counts where force rises from {low:g} to {high:g} N in {shortest:g} to {longest:g} s and the press "
        f"is {use} by the limits of [window] and [fit]. Judged by hand so far: {len(plan['judgements'])} presses or "
        "recordings."
    )


def _power(plan: Plain) -> str:
    people, presses = len(plan["participants"]), plan["tables"]["window"]["expected_trials"] or 0
    if min(people, presses) < 2:
        return ""
    power = float(power_rm(people, presses, EFFECT_F, RHO, EPSILON, 0.05))
    return f"Power for repetitions, f = {EFFECT_F:g}, α = .05: {power:.2f}."


def _order(session: Plain | None, rig: Plain | None) -> str:
    said = [f"specimens are {session['order']}, seed {session['seed']}"] if session else []
    said += [f"runs of the rig are {rig['order']}, seed {rig['seed']}"] if rig else []
    return f"{'; '.join(said)}." if said else YOURS
