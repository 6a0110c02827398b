"""Runs in this process: the same bits as the program, progress, stop and continuation."""

import os
import signal
import subprocess
import threading
from collections.abc import Iterator
from pathlib import Path

import crumple
import pytest


def test_a_run_has_the_bits_of_the_program(
    results: crumple.Results, bars: Path, tmp_path: Path
) -> None:
    """The final state is that of `crumple run` on another number of workers."""
    program = os.environ["CRUMPLE_BIN"]
    out = tmp_path / "out"
    command = [program, "run", bars, "--workers=3", "--quiet", "--no-report", f"--out={out}"]
    subprocess.run(command, check=True)
    other = crumple.open(out)
    assert other.summary["state_digest"] == results.summary["state_digest"]
    assert other.history()["kinetic [J]"].equals(results.history()["kinetic [J]"])


def test_a_job_that_was_changed_runs(bars: Path, tmp_path: Path) -> None:
    """A table runs with its changes, and its file is with the results."""
    job = crumple.Job.read(bars)
    job["end_time"] = 0.001
    seen: list[crumple.Progress] = []
    done = crumple.run(
        job, workers=1, out=tmp_path, set={"output.field_interval": -1}, progress=seen.append
    )
    assert done.status == "completed" and done.times == []
    assert seen[-1].fraction == 1.0 and seen[-1].cycle == done.summary["cycles"]
    assert crumple.Job.read(tmp_path)["end_time"] == 0.001
    with pytest.raises(crumple.RunError, match="overwrite=True"):
        crumple.run(job, out=tmp_path, progress=False)
    assert crumple.run(job, out=tmp_path, overwrite=True, progress=False).times != []


def test_all_problems_of_a_job_are_raised(bars: Path, tmp_path: Path) -> None:
    """A run with errors does not begin."""
    with pytest.raises(crumple.JobError) as raised:
        crumple.run(bars, out=tmp_path / "out", set={"end_time": -1, "part.one.thickness": 0})
    assert len(raised.value.findings) == 2
    assert not (tmp_path / "out/history.csv").exists()


LONG = {"end_time": 100.0, "output.field_interval": -1}
"""Changes for a run that does not end before it is stopped."""


@pytest.fixture
def ctrl_c() -> Iterator[None]:
    """Lets Ctrl-C raise, also if the shell that started Python ignores it."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("ctrl_c")
def test_ctrl_c_stops_with_a_checkpoint_and_resume_gives_the_same_bits(
    bars: Path, tmp_path: Path
) -> None:
    """A run that is interrupted and continued ends in the state of one that was not."""
    out = tmp_path / "out"
    sent: list[int] = []
    # The step depends on the end of the run.
    end = LONG | {"end_time": 10.0}

    def interrupt(progress: crumple.Progress) -> None:
        if progress.cycle > 0 and not sent:
            sent.append(progress.cycle)
            os.kill(os.getpid(), signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        crumple.run(bars, workers=2, out=out, set=end, report=False, progress=interrupt)
    stopped = crumple.open(out)
    assert stopped.status == "stopped" and sent[0] <= stopped.summary["cycles"]
    assert 0 < stopped.summary["end_time"] < end["end_time"]
    went_on = crumple.resume(out, workers=1, report=False, progress=False)
    assert went_on.status == "completed"
    assert went_on.summary["restarts"][0]["cycle"] == stopped.summary["cycles"]
    whole = crumple.run(
        bars, workers=1, out=tmp_path / "whole", set=end, report=False, progress=False
    )
    assert whole.summary["state_digest"] == went_on.summary["state_digest"]


def test_an_exception_of_the_progress_function_goes_on(bars: Path, tmp_path: Path) -> None:
    """The run stops with a checkpoint, and the caller gets the exception."""

    class Enough(Exception):
        pass

    def look(progress: crumple.Progress) -> None:
        raise Enough

    with pytest.raises(Enough):
        crumple.run(bars, out=tmp_path, set=LONG, report=False, progress=look)
    assert crumple.open(tmp_path).status == "stopped"


def test_a_failed_run_raises_and_keeps_its_results(bars: Path, tmp_path: Path) -> None:
    """A step above the stability limit is an error with the results so far."""
    with pytest.raises(crumple.RunError, match="time.safety") as raised:
        crumple.run(bars, out=tmp_path, set={"time.safety": 1.5}, progress=False)
    assert raised.value.results is not None
    assert raised.value.results.status == "failed"


def test_runs_in_two_threads_do_not_disturb_each_other(
    results: crumple.Results, bars: Path, tmp_path: Path
) -> None:
    """Two runs at the same time have the bits of one alone."""
    digests: list[str] = []

    def one(name: str) -> None:
        run = crumple.run(bars, workers=1, out=tmp_path / name, report=False, progress=False)
        digests.append(run.summary["state_digest"])

    threads = [threading.Thread(target=one, args=(name,)) for name in ("a", "b")]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert digests == 2 * [results.summary["state_digest"]]
