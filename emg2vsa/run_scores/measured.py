"""What every vision algorithm makes of one press: its front by the pins, and the growth of skin by each recipe."""

from __future__ import annotations

from dataclasses import dataclass, field, fields, replace

import numpy as np

from casr.camera import undistorted
from casr.contact_area import InitialArea, area_of
from casr.contact_area.motion import array_area_px2
from casr.doubts import Stretch, stretch_of
from casr.errors import CasrError
from casr.flow.estimate import FlowSettings
from casr.frames import FrameSequence
from casr.kappa.presses import KappaPress
from casr.scored import WHOLE_IMAGE, Score, ScoreSettings, SkinScore
from casr.scoring import Begun, score_press, score_skin
from emg2vsa.arrays import Floats
from emg2vsa.run_scores.domes import NO_DOMES, Domes
from emg2vsa.run_scores.product import PressPins
from emg2vsa.settings import RECIPES, Recipe, RunSettings


@dataclass(frozen=True, eq=False)
class Numbers:
    """Numbers of one algorithm, NaN where it finds nothing; ``missing`` : why there is no rate.

    area, outlines_px : (T,) and T outlines, of the frames. over_array : the largest area over that of the pin array,
    where it is above it, so that there is no rate.
    """

    a_c0: float = np.nan
    start_area: float = np.nan
    casr: float = np.nan
    area: Floats = field(default_factory=lambda: np.empty(0))
    outlines_px: tuple[Floats, ...] = ()
    missing: str = ""
    over_array: float = np.nan


class Measured:
    """A press, by its pins and by what else the recipes ask for.

    The front and the growth of skin by the pins' flow come from one pass over the frames. A recipe with another engine,
    force rule, law, rate or region takes a further one. The rule of the initial area takes none: growth does not depend
    on it.

    Attributes
    ----------
    skin : by the recipe of the settings.

    Raises
    ------
    CasrError : the algorithm of the settings finds nothing.
    """

    def __init__(self, frames: FrameSequence, settings: RunSettings, domes: Domes = NO_DOMES) -> None:
        self._frames, self._settings, self._domes, own = frames, settings, domes, settings.recipe
        is_front = settings.algorithm == "front"
        self._by_pins = own if is_front or _growth(own) == _growth(RECIPES["front"]) else RECIPES["front"]
        self._skins: dict[Recipe, SkinScore] = {}
        self._begun = Begun()
        self._seen: Score | None = None
        try:
            by_skin = own == self._by_pins and not is_front
            self._seen = score_press(*self._asked(self._by_pins, "skin" if by_skin else "front"), self._begun)
            self._skins[_growth(self._by_pins)] = _skin_of(self._seen)
        except CasrError:
            if own == self._by_pins:
                raise
        self.skin = self._skin_by(own)
        if is_front:
            self._need_front()
        elif self.skin.initial.rule != own.area_rule:
            raise CasrError(
                frames.name,
                wanted=f"an initial area by rule {own.area_rule!r}",
                found=" ".join(self.skin.initial.notes),
                do="Look at the first frames (casr score --page); if they are as they should be, set another "
                "algorithm.",
            )

    @property
    def stretch(self) -> Stretch | None:
        """How the skin of first contact grew against the contact; None where the front is not determined."""
        return None if self._seen is None else stretch_of(self._seen)

    @property
    def pins(self) -> PressPins | None:
        """What stiffness is told from by the pins, (N, 2) px and (T, N, 2) px; None where they cannot be followed in
        enough frames."""
        seen = self._seen
        if seen is None or seen.force_n is None:
            return None
        try:
            press = KappaPress.of_score(seen)
            press.seen()
        except CasrError:
            return None
        return PressPins(press.rest_px, press.pins_px.astype(np.float32), seen.force_n, press.force_zero_sd_n)

    def _need_front(self) -> None:
        assert self._seen is not None
        if self._seen.rate is None:
            raise CasrError(
                self._frames.name,
                wanted="a contact front that can be followed",
                found=self._seen.front_doubt,
                do="Look at the frames (casr score --page), or set another algorithm under [runs].",
            )

    def numbers(self, algorithm: str) -> Numbers:
        """Those of one algorithm; with the reason where it has none."""
        try:
            return self._front() if algorithm == "front" else self._by_skin(self._settings.recipe_of(algorithm))
        except CasrError as error:
            return Numbers(missing=f"expected {error.wanted}, but found {error.found}")

    @property
    def by_paper(self) -> SkinScore | None:
        """The skin by the recipe "paper"; None where nobody asked for its numbers, or it finds none."""
        return self._skins.get(_growth(self._settings.recipe_of("paper")))

    @property
    def notes(self) -> tuple[str, ...]:
        """What a reader of the press's numbers should know."""
        doubts = self._seen.doubts if self._seen else ()
        return (*(f"check {self._frames.name}: {doubt}" for doubt in doubts), *self.skin.notes)

    def _front(self) -> Numbers:
        """Area in the first frame and where loading begins, on the front's power law, and its rate."""
        seen = self._seen
        if seen is None or seen.force_n is None or seen.front_spread is None or seen.front_spread.rate is None:
            return Numbers(missing=seen.front_doubt if seen else "the pins cannot be followed")
        rate = seen.front_spread.rate
        assert rate.law is not None
        start_n, first_n = self._settings.force_n[0], float(seen.force_n[0])
        area, outlines = seen.by("front").area, tuple(seen.front.edge_px)
        return Numbers(rate.law.area(first_n), rate.law.area(start_n), rate.value, area, outlines)

    def _by_skin(self, recipe: Recipe) -> Numbers:
        found = self._skin_by(recipe)
        initial = self._initial(found, recipe.area_rule)
        if initial.rule != recipe.area_rule:
            return Numbers(missing=f"expected an initial area by its rule, but found: {' '.join(initial.notes)}")
        a_c0 = initial.area_px2 if initial.area_mm2 is None else initial.area_mm2
        times, rate = a_c0 / found.skin.area[0], found.skin.rate
        assert rate is not None
        growth = rate.law.area(self._settings.force_n[0]) / found.skin.area[0] if rate.law else 1.0
        area = times * found.skin.area
        array = self._array_area(found, initial)
        first = int(initial.rule == "circle")  # in the first frame a circle is of the array itself
        last = first + int(np.argmax(area[first:]))
        # a circle that grows as its skin was seen to grow is still of the array's skin; equation (1) sees no skin
        if area[last] > array and not (first and recipe.law == "ode"):
            unit = found.area_unit.replace("2", "²")
            missing = (
                f"expected at most the area of the pin array, {array:.5g} {unit}, but found {area[last]:.5g} {unit} "
                f"by the area law at {found.force_n[last]:.2f} N"
            )
            return Numbers(a_c0, a_c0 * growth, missing=missing, over_array=float(area[last] / array))
        return Numbers(a_c0, a_c0 * growth, float(times * rate.value), area, found.regions)

    def _array_area(self, found: SkinScore, initial: InitialArea) -> float:
        """Area of the pin array in the first frame, in the unit of areas: no contact is larger."""
        scale = 1.0 if initial.area_mm2 is None else initial.area_mm2 / initial.area_px2
        return scale * array_area_px2(undistorted(found.contact_px, self._frames.camera))

    def _initial(self, found: SkinScore, rule: str) -> InitialArea:
        if found.initial.rule == rule:
            return found.initial
        camera, threshold_px = self._frames.camera, self._settings.threshold_px
        return area_of(found.first_contact, camera, rule, threshold_px)

    def _skin_by(self, recipe: Recipe) -> SkinScore:
        key = _growth(recipe)
        if key not in self._skins:
            taken = self._seen.frames if self._seen else np.empty(0, dtype=np.intp)
            bad = np.setdiff1d(np.arange(taken[0], taken[-1]), taken) if taken.size else taken
            own = key == _growth(self._settings.recipe)  # of the others nobody reads the notes
            asked = self._asked(recipe, "skin")
            self._skins[key] = score_skin(*asked, bad.tolist(), doubt_pins=own, known=self._begun)
        return self._skins[key]

    def _asked(self, recipe: Recipe, quantity: str) -> tuple[FrameSequence, ScoreSettings]:
        frames, asked = asked_of(self._frames, self._settings, recipe, quantity)
        lag = self._seen.camera_lag if self._seen and frames.readings else None
        return frames, replace(asked, camera_lag_s=lag.corrected_s if lag else None, **self._domes._asdict())


def asked_of(
    frames: FrameSequence, settings: RunSettings, recipe: Recipe, quantity: str
) -> tuple[FrameSequence, ScoreSettings]:
    """The frames with their forces, and a recipe in casr's terms."""
    frames = frames.by_mean() if recipe.force_rule == "mean" else frames
    start_n, stop_n = settings.force_n
    asked = ScoreSettings(
        quantity=quantity,
        flow=FlowSettings(engine=recipe.engine),
        area_rule=recipe.area_rule,
        area_law=recipe.law,
        rate_rule=recipe.rate,
        threshold_px=settings.threshold_px,
        force_start_n=start_n,
        force_stop_n=stop_n,
        region=WHOLE_IMAGE if recipe.region == "image" else None,
    )
    return frames, asked


def _growth(recipe: Recipe) -> Recipe:
    """What growth depends on."""
    return recipe._replace(area_rule="")


def _skin_of(seen: Score) -> SkinScore:
    return SkinScore(**{each.name: getattr(seen, each.name) for each in fields(SkinScore)})
