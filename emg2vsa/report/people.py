"""What a report says of the people: of all together, never of one."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from emg2vsa.study import Person

_SEX = {"f": "female", "m": "male", "o": "other"}
_HAND = {"r": "right", "l": "left", "a": "ambidextrous"}
FEWEST_TOLD = 5
"Fewest people of whom anything is told. Single people of a smaller group could be recognised."


def about_people(people: Sequence[Person]) -> str:
    """Sex, age and handedness as far as the table of participants tells them: "6 female, 8 male; aged 21 to 34 ...".

    Nothing of a group that is so small that single people could be known by it.
    """
    said: list[str] = []
    if len(people) < FEWEST_TOLD:
        return ""
    for words, names in (([each.sex for each in people], _SEX), ([each.handedness for each in people], _HAND)):
        counts = Counter(names.get(word.lower(), word.lower()) or "not stated" for word in words)
        if set(counts) - {"not stated"}:
            said.append(", ".join(f"{n} {kind}" for kind, n in sorted(counts.items())))
    years = [float(person.age.rstrip("+")) for person in people if person.age]
    if years:
        from statistics import fmean, stdev  # planning a study without ages does without it

        sd = stdev(years) if len(years) > 1 else 0.0
        known = f" ({len(years)} of {len(people)})" if len(years) < len(people) else ""
        said.append(f"aged {min(years):g} to {max(years):g} years, mean {fmean(years):.1f}, SD {sd:.1f}{known}")
    return "; ".join(said)
