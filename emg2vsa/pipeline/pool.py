"""The tasks of a study on several processes; a process that dies takes only its own task with it."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from emg2vsa.pipeline.tasks import Ended, Task
from emg2vsa.process_pool import ProcessPool, WorkerDied

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
