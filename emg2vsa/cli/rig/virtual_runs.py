"""Any number of runs on the emulated rig, side by side, in virtual time."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, replace
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import Any

from casr.command_line import print_json
from casr.terminal import note
from emg2vsa.cli.rig.ending import summary
from emg2vsa.cli.rig.kappa_options import KappaPlans, say_kappa, say_reachable
from emg2vsa.cli.rig.same_presses import check_same_presses
from emg2vsa.errors import Emg2vsaError, SettingError
from emg2vsa.process_pool import ProcessPool, WorkerDied
from emg2vsa.rig.emulated.controls import ArtificialEffect, effect_of
from emg2vsa.rig.emulated.settings import EmulatedSettings
from emg2vsa.rig.emulated.virtual_run import run_virtual
from emg2vsa.rig.executor.guards import laxer_guards
from emg2vsa.rig.executor.plan_limits import check_plan
from emg2vsa.rig.experiment import run_name
from emg2vsa.rig.kappa.live_kappa import KappaPlan
from emg2vsa.rig.plan import RunPlan
from emg2vsa.rig.record.ended import Ended
from emg2vsa.rig.record.new_folder import new_folder, presses_left
from emg2vsa.rig.rig_settings import RigSettings
from emg2vsa.rig_file import RigFile
from emg2vsa.rig_file.plans import Run, plans_of, read_schedules
from emg2vsa.rig_file.sequence import RunOrder
from emg2vsa.schedules import Schedule

_BEFORE = "done before"


Job = tuple[RunPlan, RigSettings, EmulatedSettings, Path, ArtificialEffect | None, KappaPlan | None]


def run_virtually(
    file: RigFile,
    runs: Sequence[Run],
    root: Path,
    repetitions: int | None,
    jobs: int,
    *,
    order: RunOrder,
    kappa: KappaPlans,
    as_json: bool = False,
) -> int:
    """The presses that ``runs`` lack, in ``order``; exit status.

    SettingError : the rig file has no emulated rig, or a plan breaks a limit. ScheduleError : as `plans_of`.
    """
    emulated = _emulated(file)
    runs = [run for run in order.runs if run in runs]
    plans = dict(zip(runs, plans_of(file, runs, repetitions), strict=True))
    right = _right_schedules(file)
    for run, plan in plans.items():
        check_plan(plan, file.rig)
        check_same_presses(root, run.name, plan, file.rig, emulated=True)
    judged = kappa(plans)
    for line in () if as_json else laxer_guards(file.rig):
        print(f"guard: {line}")
    start = time.monotonic()
    results: dict[Run, Ended | str] = {}
    waiting: dict[Run, Job] = {}
    for run, plan in plans.items():
        if presses := presses_left(root, run.name, plan.repetitions, emulated=True):
            plans[run] = replace(plan, repetitions=presses, order=order.place(run) if len(runs) > 1 else None)
            folder = new_folder(root, run.name, plan.repetitions, emulated=True)
            effect = effect_of(emulated, plan.schedule, right)
            waiting[run] = plans[run], file.rig, emulated, folder, effect, judged[run]
            if (plan_of_kappa := judged[run]) is not None and not as_json:
                say_reachable(plan_of_kappa, plans[run], emulated=True)
        else:
            results[run] = _BEFORE
    for run, result in _carried_out(waiting, jobs):
        results[run] = result
        line = result if isinstance(result, str) else summary(result, plans[run].repetitions)
        note(f"{len(results)}/{len(runs)} {run.name}: {line}")
        if isinstance(result, Ended) and result.how == "interrupted":
            raise KeyboardInterrupt
    ends = [result for result in results.values() if isinstance(result, Ended)]
    rig_min, took_min = sum(ended.time_s for ended in ends) / 60, (time.monotonic() - start) / 60
    status = int(any(ended.how != "completed" for ended in ends) or len(ends) < len(waiting))
    for job in () if as_json else waiting.values():
        if job[-1] is not None:
            say_kappa(job[3])
    if as_json:
        print_json({"folder": str(root), "runs": [_document(run, results[run]) for run in plans]})
        return status
    listed = {run: plans[run] for run in file.experiment.all_runs() if run in plans}
    print("\n".join(_table(results, listed)))
    print(f"runs done: {len(ends)}, {rig_min:.1f} min of the rig's time in {took_min:.1f} min; folder {root}")
    return status


def press_virtually(file: RigFile, plan: RunPlan, folder: Path, kappa: KappaPlan) -> Ended:
    """Carry out ``plan`` on the emulated rig, recorded in ``folder``. SettingError : the rig file has none."""
    emulated = _emulated(file)
    effect = effect_of(emulated, plan.schedule, _right_schedules(file))
    return _run(plan, file.rig, emulated, folder, effect, kappa)


def _emulated(file: RigFile) -> EmulatedSettings:
    if file.emulated is None:
        do = "Add it (docs/reference/rig-file.md), or leave out --virtual."
        raise SettingError(file.path, wanted="a table [emulated]", found="none", do=do)
    return file.emulated


def _document(run: Run, result: Ended | str) -> dict[str, Any]:
    if isinstance(result, Ended):
        return run._asdict() | {"ended": asdict(result)}
    return run._asdict() | {"ended": None, "note": result}


def _carried_out(waiting: Mapping[Run, Job], jobs: int) -> Iterator[tuple[Run, Ended | str]]:
    """Every run and how it ended, or why there is none, in the order of their ends."""
    runs, calls = list(waiting), [partial(_run, *job) for job in waiting.values()]
    with ProcessPool(min(jobs, len(calls))) as pool:
        for i, result in pool.ended(calls, load=[__name__]):
            yield runs[i], _outcome(result)


def _right_schedules(file: RigFile) -> tuple[Schedule, ...]:
    """What the noise of control P4 is matched to."""
    assert file.emulated is not None
    named = file.emulated.control_specimen
    return read_schedules(file.schedules, [Run(named, 0.0, "modular")], {}) if named else ()


def _run(
    plan: RunPlan,
    rig: RigSettings,
    emulated: EmulatedSettings,
    folder: Path,
    effect: ArtificialEffect | None,
    kappa: KappaPlan | None,
) -> Ended:
    started, name = datetime.now(UTC), run_name(plan.specimen, plan.angle_deg, plan.condition, plan.mounting)
    return run_virtual(
        plan, rig, emulated, folder, started=started, run=folder.name, mounted=name, effect=effect, kappa=kappa
    )


def _outcome(make: Callable[[], Ended]) -> Ended | str:
    try:
        return make()
    except Emg2vsaError as error:
        return f"not run. {error}"
    except WorkerDied as error:
        return f"not run: {error}"


def _table(results: Mapping[Run, Ended | str], plans: Mapping[Run, RunPlan]) -> Iterator[str]:
    """Presses done, condition and angle by specimen."""
    specimens = list(dict.fromkeys(run[0] for run in plans))
    rows = dict.fromkeys(run[1:] for run in plans)
    several = any(mounting > 1 for _, _, mounting in rows)
    yield f"{'presses done':<27}" + "".join(f"{specimen:>12}" for specimen in specimens)
    for angle_deg, condition, mounting in rows:
        cells = [_cell(results, plans, Run(specimen, angle_deg, condition, mounting)) for specimen in specimens]
        title = f"{condition}, {angle_deg:g} degrees" + (f" ({mounting})" if several else "")
        yield f"{title:<27}" + "".join(f"{cell:>12}" for cell in cells)


def _cell(results: Mapping[Run, Ended | str], plans: Mapping[Run, RunPlan], run: Run) -> str:
    if run not in plans:
        return ""
    result = results[run]
    if isinstance(result, str):
        return "done before" if result == _BEFORE else "not run"
    return f"{result.repetitions_done}" if result.how == "completed" else f"{result.repetitions_done}, {result.cause}"
