"""The tables of a study."""

from __future__ import annotations

import numpy as np

from emg2vsa.figures.activity_scale import ActivityScale, activity_scale
from emg2vsa.fits import usable
from emg2vsa.profiles import Profiles
from emg2vsa.report.hypothesis_tables import hypothesis_tables
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.table import Cell, Column, Table, activity_column, rows_of
from emg2vsa.schedules import Schedule
from emg2vsa.truth import recover


def study_tables(results: StudyResults) -> dict[str, Table]:
    """Name to table; those of a stage that failed are absent."""
    scale = scale_of(results)
    tables = [_fits(results, scale), _fits_by_specimen(results, scale)]
    if results.hypotheses is not None:
        tables += hypothesis_tables(results.hypotheses, scale)
    if results.profiles is not None:
        tables += [_profiles(results.profiles, scale), _leave_one_out(results.profiles, scale)]
    if results.schedules:
        tables.append(_schedules(results.schedules, scale))
    if results.truth is not None:
        tables.append(_recovery(results))
    return {table.name: table for table in tables}


def scale_of(results: StudyResults) -> ActivityScale:
    """The unit of all activities of the report."""
    fits = results.fitted
    return activity_scale(fits.activity_unit, fits.v_max_v[usable(fits, results.study.hypotheses.use)])


_R2_HEADS = {
    "adj_r2": "adj. R²", "r2_bins": "R², bins", "adj_r2_bins": "adj. R², bins", "r2_samples": "R², samples",
    "adj_r2_samples": "adj. R², samples",
}  # fmt: skip


def _fits(results: StudyResults, scale: ActivityScale) -> Table:
    fits = results.fitted
    texts = {"participant": "Participant", "specimen": "Specimen", "repetition": "Press", "verdict": "Verdict"}
    activities = {"a_v": "a", "b_v": "b", "a_se_v": "SE a", "b_se_v": "SE b", "b_lo_v": "b low", "b_hi_v": "b high"}
    others = {"n_points": "Points", **_R2_HEADS, "n_effective": "n effective", "lag1": "lag-1", "start_s": "Start (s)"}
    columns = (
        *(Column(key, head) for key, head in texts.items()),
        *(activity_column(key, head, scale) for key, head in activities.items()),
        *(Column(key, head) for key, head in others.items()),
        Column("reason", "Reason"),
    )
    return Table(
        "fits", "All trials, rejected ones included: fit v = a + b ln F", columns,
        rows_of(*(getattr(fits, column.key) for column in columns)),
    )  # fmt: skip


def _fits_by_specimen(results: StudyResults, scale: ActivityScale) -> Table:
    fits, rows = results.fitted, []
    used = usable(fits, results.study.hypotheses.use)
    for specimen in results.study.specimens:
        of = used & (fits.specimen == specimen.name)
        n, b = int(np.count_nonzero(of)), fits.b_v[of]
        rows.append(
            (
                specimen.name, specimen.stiffness_n_per_mm, int(np.count_nonzero(fits.specimen == specimen.name)), n,
                float(np.mean(fits.a_v[of])) if n else None, float(np.mean(b)) if n else None,
                float(np.std(b, ddof=1)) if n > 1 else None, float(np.min(fits.adj_r2_bins[of])) if n else None,
                float(np.median(fits.adj_r2_bins[of])) if n else None,
                float(np.min(fits.adj_r2_samples[of])) if n else None,
                float(np.median(fits.adj_r2_samples[of])) if n else None,
            )
        )  # fmt: skip
    columns = (
        Column("specimen", "Specimen"),
        Column("stiffness_n_per_mm", "Stiffness κ (N/mm)"),
        Column("trials", "Trials"),
        Column("used", "Used"),
        activity_column("a_mean_v", "Mean a", scale),
        activity_column("b_mean_v", "Mean b", scale),
        activity_column("b_sd_v", "SD b", scale),
        Column("adj_r2_bins_min", "Worst adj. R², bins"),
        Column("adj_r2_bins_median", "Median adj. R², bins"),
        Column("adj_r2_samples_min", "Worst adj. R², samples"),
        Column("adj_r2_samples_median", "Median adj. R², samples"),
    )
    return Table("fits_by_specimen", "Fits v = a + b ln F of the trials used, by specimen", columns, tuple(rows))


def _profiles(profiles: Profiles, scale: ActivityScale) -> Table:
    shown = [*profiles.profiles, *([profiles.new] if profiles.new else [])]
    columns = (
        Column("specimen", "Specimen"),
        Column("stiffness_n_per_mm", "Stiffness κ (N/mm)"),
        Column("source", "Source"),
        Column("n_trials", "Trials"),
        activity_column("a_v", "a", scale),
        activity_column("b_v", "b", scale),
    )
    rows = tuple(tuple(getattr(profile, column.key) for column in columns) for profile in shown)
    return Table("profiles", f"Mean profiles of {profiles.participant or 'all participants'}", columns, rows)


def _leave_one_out(profiles: Profiles, scale: ActivityScale) -> Table:
    columns = (
        Column("specimen", "Left out"), Column("bracket", "Interpolated from"),
        activity_column("rmse_v", "RMSE", scale), Column("relative", "RMSE (% of root mean square)", 100.0),
    )  # fmt: skip
    rows = tuple(
        (left.specimen, " and ".join(left.bracket) if left.bracket else None, left.rmse_v, left.relative)
        for left in profiles.leave_one_out
    )
    return Table("leave_one_out", "Each measured profile beside its interpolation from its neighbours", columns, rows)


def _schedules(schedules: tuple[Schedule, ...], scale: ActivityScale) -> Table:
    columns = (
        Column("specimen", "Specimen"), Column("condition", "Condition"), Column("from_n", "From (N)"),
        Column("to_n", "To (N)"), activity_column("activity_v", "Co-contraction", scale),
        Column("stiffness_percent", "Stiffness (%)"), Column("preset_ticks", "Preset (ticks)"),
        Column("stiffness_nm_per_rad", "Stiffness at zero load (N·m/rad)"),
    )  # fmt: skip
    rows = tuple(
        row
        for s in schedules
        for row in rows_of(
            [s.specimen] * len(s.preset_ticks), [s.condition] * len(s.preset_ticks), s.step_force_n[:-1],
            s.step_force_n[1:], s.activity_v, s.stiffness_percent, s.preset_ticks, s.stiffness_nm_per_rad,
        )
    )  # fmt: skip
    starts = np.cumsum([0, *(len(s.preset_ticks) for s in schedules)]).tolist()
    shown: list[tuple[Cell, ...]] = []
    for s, first, after in zip(schedules, starts[:-1], starts[1:], strict=True):
        of = rows[first:after]
        shown += of if s.condition == "modular" else [(*of[0][:3], of[-1][3], *of[0][4:])]
    caption = "Stiffness schedules: every step where the stiffness changes, one row where it is constant"
    return Table("schedules", caption, columns, rows, tuple(shown))


def _recovery(results: StudyResults) -> Table:
    assert results.truth is not None
    columns = (
        Column("specimen", "Specimen"), Column("n", "Trials"), Column("mean_b_error", "Mean error of b (%)", 100.0),
        Column("mean_b_error_mcse", "Monte-Carlo SE (%)", 100.0, 2), Column("sd_b_error", "SD of the error (%)", 100.0),
        Column("coverage", "Intervals that cover (%)", 100.0), Column("coverage_mcse", "Monte-Carlo SE (%)", 100.0, 2),
    )  # fmt: skip
    use, rows = results.study.hypotheses.use, []
    for name in [None, *(specimen.name for specimen in results.study.specimens)]:
        found = recover(results.fitted, results.truth, use, name)
        rows.append((name or "all", *(getattr(found, column.key) for column in columns[1:])))
    return Table("recovery", "Fitted against true slopes of the simulation", columns, tuple(rows))
