"""The progress bar."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from neurbs import Progress


@contextmanager
def progress_bar(shown: bool, name: str = "") -> Iterator[Callable[[Progress], None] | None]:
    """Give what draws the progress on a terminal, and `None` where there is none.

    Stage, steps, their rate, the error so far, the time passed and what it will take at most.
    """
    if not shown or sys.stderr is None or not sys.stderr.isatty():
        yield None
        return
    from rich import progress as rich
    from rich.console import Console
    from rich.table import Column

    def text(form: str) -> rich.ProgressColumn:
        # On a narrow terminal the bar makes room, not the numbers.
        return rich.TextColumn(form, table_column=Column(no_wrap=True))

    columns = (
        text("{task.description}"),
        rich.BarColumn(),
        text("{task.completed:,.0f}/{task.total:,.0f}"),
        text("{task.fields[rate]}{task.fields[error]}"),
        rich.TimeElapsedColumn(),
        text("of"),
        rich.TimeRemainingColumn(elapsed_when_finished=True),
    )
    with rich.Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        tasks: dict[str, rich.TaskID] = {}

        def draw(progress: Progress) -> None:
            stage = progress.stage
            if stage not in tasks:
                # A stage at a time: each has its own rate.
                for task in tasks.values():
                    bar.update(task, visible=False)
                description = f"{name} {stage}".strip()
                tasks[stage] = bar.add_task(description, total=progress.total, rate="", error="")
            speed = bar.tasks[bar.task_ids.index(tasks[stage])].speed
            bar.update(
                tasks[stage],
                completed=progress.step,
                total=progress.total,
                rate=f"{speed:,.0f}/s" if speed else "",
                error="" if progress.error is None else f", error {progress.error:.3g}",
            )

        yield draw
