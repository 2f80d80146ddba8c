"""Carrying out steps, here or in worker processes: whatever goes wrong stays with the step."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from casr.by_name import noting
from casr.errors import PassingError, UserError
from emg2vsa import artifacts
from emg2vsa.pipeline.profile import Spent, measured
from emg2vsa.pipeline.stage import Given
from emg2vsa.pipeline.stage_order import stage
from emg2vsa.pipeline.store import ClaimedElsewhere, claimed, written_files
from emg2vsa.process_pool import ProcessPool, WorkerDied


@dataclass(frozen=True)
class Ended:
    """How one step ended.

    status : done or failed. message : what went wrong, or what a person should read of the product. final : the same
    input would fail the same way. damaged : stored result that could not be read, "" where all could. spent : what it
    took, where the task was asked. loaded : what it imported or looked up by name.
    """

    step: str
    status: str
    message: str = ""
    final: bool = False
    damaged: str = ""
    spent: Spent | None = None
    loaded: tuple[str, ...] = ()


@dataclass(frozen=True)
class Task:
    """A step to be carried out: its product goes to ``unfinished``, and ``claim`` says meanwhile who works at it.

    profiled : how it ended tells what it took.
    """

    step: str
    given: Given
    unfinished: Path
    claim: Path
    profiled: bool = False

    def __call__(self) -> Ended:
        with noting() as loaded:
            if not self.profiled:
                ended = self._ended()
            else:
                with measured() as spent:
                    ended = self._ended()
                ended = replace(ended, spent=spent)
        return replace(ended, loaded=tuple(sorted(loaded)))

    def _ended(self) -> Ended:
        try:
            with claimed(self.claim):
                return Ended(self.step, "done", self._make())
        except artifacts.DamagedResult as error:
            return Ended(self.step, "failed", str(error), damaged=error.where)
        except ClaimedElsewhere as error:
            return Ended(self.step, "failed", str(error))
        except UserError as error:
            return Ended(self.step, "failed", str(error), final=not isinstance(error, PassingError))
        except OSError as error:  # the disk is full, or a folder may not be written to: the same input may do next time
            where = f"{error.filename}: " if error.filename else ""
            what = (error.strerror or str(error)).rstrip(".")
            return Ended(self.step, "failed", f"{where}{what}. Mend that, and run the study again.")
        except Exception as error:
            import traceback

            frame = traceback.extract_tb(error.__traceback__)[-1]
            place = f"{Path(frame.filename).name}:{frame.lineno}"
            what = f"unexpected {type(error).__name__} in {place}: {error}"
            return Ended(self.step, "failed", f"{what}. This is a fault of the program; please report it.")

    def _make(self) -> str:
        declared = stage(self.step.partition("/")[0])
        product = declared.run(self.given)
        if self.given.folder is not None:
            product = written_files(self.given.folder, product)
        artifacts.save(self.unfinished, product)
        return declared.says(product)


OnEnd = Callable[[Ended], None]


class Workers(ProcessPool):
    """What a worker has loaded for one stage serves the next."""

    def run(self, tasks: Sequence[Task], on_end: OnEnd, *, alone: int = 1, load: Sequence[str] = ()) -> None:
        """Run all tasks, and report each as it ends.

        alone : up to so many run in this process, as starting workers would take longer. load : modules that the
        workers have in common, of all that they will do; only the first use of them counts.
        """
        if len(tasks) <= alone:
            for task in tasks:
                on_end(task())
            return
        for task in self._side_by_side(tasks, on_end, load):
            # some process died: one at a time, so that the task that kills it is known
            if self._side_by_side([task], on_end, load):
                died = f"{WorkerDied()}. Run again with --jobs 1 if memory is short."
                on_end(Ended(task.step, "failed", died))

    def _side_by_side(self, tasks: Sequence[Task], on_end: OnEnd, load: Sequence[str]) -> list[Task]:
        """The tasks that were not done because a process died."""
        died = []
        for i, result in self.ended(tasks, load):
            try:
                ended = result()
            except WorkerDied:
                tasks[i].claim.unlink(missing_ok=True)
                died.append(tasks[i])
            else:
                on_end(ended)
        return died
