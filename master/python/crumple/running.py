"""Runs of jobs in threads of this process."""

from __future__ import annotations

import logging
import os
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from . import _native
from ._options import changes
from .errors import RunError
from .job import Job
from .results import Results
from .results import open as open_results

FAILED = 3
"""Exit code of a run with a numerical failure."""
LOG = logging.getLogger("crumple")
LINE_EVERY = 0.5
"""Interval between lines of progress [s]."""


@dataclass(frozen=True)
class Progress:
    """State of a run."""

    cycle: int
    """Cycles completed."""
    time: float
    """Simulated time, in the unit of the job."""
    end_time: float
    """Time at which the run ends; 0 before it has begun."""
    dt: float
    """Step size."""
    energy_error: float
    """Error of the energy balance as a fraction."""
    pairs: int
    """Active contact pairs."""
    imbalance: float
    """Critical path over the mean CPU time of the workers."""

    @property
    def fraction(self) -> float:
        """Simulated time over the end, from 0 to 1."""
        return min(self.time / self.end_time, 1.0) if self.end_time > 0 else 0.0

    def __str__(self) -> str:
        return (
            f"{100 * self.fraction:5.1f} %  cycle {self.cycle}  time {self.time:.4e}  "
            f"dt {self.dt:.3e}  energy error {100 * self.energy_error:.2f} %"
        )


def run(
    job: Job | str | os.PathLike[str],
    *,
    workers: int | None = None,
    out: str | os.PathLike[str] | None = None,
    set: Mapping[str, object] | None = None,
    overwrite: bool = False,
    report: bool = True,
    progress: bool | Callable[[Progress], object] = True,
) -> Results:
    """Runs a job to its end in threads of this process, and returns its results.

    `job` is a job, a job file, a folder with `job.toml`, or a deck. `workers` is the number of
    workers, by default one for each core. `out` is the folder for results, by default `out/` and
    the name of the job; a `Job` is written there as `job.toml`. `set` changes keys of the job,
    such as `{"end_time": 5.0, "part.rail.thickness": 2}`. `progress` shows a line, or calls a
    function.

    Messages of the run go to the logger `crumple`. Ctrl-C, or an exception of the function for
    progress, stops the run with a checkpoint, from which `resume` continues, and goes on.

    Raises `JobError` with all problems of the job, and `RunError`.
    """
    options: dict[str, Any] = {"resume": None, "overwrite": overwrite}
    if isinstance(job, Job):
        folder = Path(out) if out is not None else Path("out") / job.name
        file = folder / "job.toml"
        if file.exists() and not overwrite:
            raise RunError(f"{folder} has a job already; give overwrite=True or another out")
        options |= {"job": os.fspath(job.write(file)), "out": os.fspath(folder)}
    else:
        options |= {"job": os.fspath(job), "out": None if out is None else os.fspath(out)}
    return _run(options, workers, set, report, progress)


def resume(
    folder: str | os.PathLike[str],
    *,
    workers: int | None = None,
    set: Mapping[str, object] | None = None,
    report: bool = True,
    progress: bool | Callable[[Progress], object] = True,
) -> Results:
    """Continues the run in `folder` from its newest checkpoint; else as `run`."""
    options = {"job": None, "out": None, "resume": os.fspath(folder), "overwrite": False}
    return _run(options, workers, set, report, progress)


def _run(
    options: dict[str, Any],
    workers: int | None,
    set: Mapping[str, object] | None,
    report: bool,
    progress: bool | Callable[[Progress], object],
) -> Results:
    options |= {"workers": workers, "set": changes(set), "report": report}
    line = ProgressLine() if progress is True else None
    show = progress if callable(progress) else line.show if line else None

    def look(numbers: tuple[int, float, float, float, float, int, float], said: list[str]) -> None:
        for message in said:
            is_warning = message.startswith("warning")
            LOG.log(logging.WARNING if is_warning else logging.INFO, "%s", message.rstrip())
        if show is not None:
            show(Progress(*numbers))

    try:
        code, folder = _native.run(options, look)
    finally:
        if line:
            line.end()
    results = open_results(folder)
    if code == FAILED:
        raise RunError(str(results.summary["reason"]), results)
    return results


class ProgressLine:
    """A line on standard error that changes."""

    def __init__(self) -> None:
        self._last = 0.0
        self._shown = False

    def show(self, progress: Progress) -> None:
        """Shows the state, at most twice a second."""
        now = time.monotonic()
        if progress.end_time > 0 and now - self._last > LINE_EVERY:
            self._last, self._shown = now, True
            print(f"\r{progress}", end="", file=sys.stderr, flush=True)

    def end(self) -> None:
        """Ends the line, if there is one."""
        if self._shown:
            print(file=sys.stderr)
