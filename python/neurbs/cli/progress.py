"""The progress bar of a command."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from neurbs import Progress


@contextmanager
def progress_bar(shown: bool, name: str = "") -> Iterator[Callable[[Progress], None] | None]:
    """Yield a callback that draws the progress on a terminal, or None if there is no terminal.

    The bar shows the share that is done, the stage, the error, the time passed and the time left.
    """
    if not shown or sys.stderr is None or not sys.stderr.isatty():
        yield None
        return
    from rich import progress as rich
    from rich.console import Console
    from rich.table import Column

    def text(form: str) -> rich.ProgressColumn:
        # On a narrow terminal the bar shrinks, not the numbers.
        return rich.TextColumn(form, table_column=Column(no_wrap=True))

    columns = (
        text("{task.description}"),
        rich.BarColumn(),
        rich.TaskProgressColumn(),
        text("{task.fields[stage]}{task.fields[error]}"),
        rich.TimeElapsedColumn(),
        text("of"),
        rich.TimeRemainingColumn(elapsed_when_finished=True),
    )
    with rich.Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(name, total=1.0, stage="", error="")

        def draw(progress: Progress) -> None:
            share = progress.share
            if share is None:
                share = progress.step / max(progress.total, 1)
            bar.update(
                task,
                completed=share,
                stage=progress.stage,
                error="" if progress.error is None else f", error {progress.error:.3g}",
            )

        yield draw
