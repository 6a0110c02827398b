"""Uses the Python client against the service at SERVICE_DIR: submits, waits, reads, stops, resumes.

    python_client.py SERVICE_DIR JOB ARCHIVE OUT
"""

import sys
import time
from pathlib import Path

import crumple
import pyvista

folder, job_file, archive, out = sys.argv[1:]
service = crumple.Service.in_folder(folder)
done = service.submit(job_file, workers=2, priority=5, name="two bars").wait(timeout=200)
assert (done.state, done.code, done.name) == ("completed", 0, "two bars"), done.about
assert done.about["workers"] == 2 and done.about["priority"] == 5, done.about
assert "memory" in done.findings()

history = done.history()
assert len(history) > 1 and history["cycle"].is_monotonic_increasing, history
assert history["time [ms]"].iloc[-1] > 0
assert set(done.history("parts.csv")["name"]) == {"one", "two"}

times = done.times()
grid = done.fields()
assert isinstance(grid, pyvista.UnstructuredGrid) and grid.n_cells > 0
assert "von_mises" in grid.cell_data and len(times) > 1, (grid, times)
assert done.fields(0).n_cells == grid.n_cells
# Only the first moves in the beginning.
assert abs(done.fields(0)["displacement"]).max() < abs(grid["displacement"]).max()
try:
    done.fields(len(times))
    raise SystemExit("a step that does not exist was returned")
except IndexError:
    pass

copied = done.fetch(out, only="results/history")
assert (copied / "results/history.csv").read_bytes() == done.read("results/history.csv")
assert not list(Path(out).rglob("*.part"))

# The same job from an archive, with changes.
packed = service.submit(archive, set={"end_time": 0.01}, check_only=True)
assert packed.wait(timeout=200).state == "checked", packed.about
assert "input/bars/job.toml" in packed.files()

endless = {"end_time": 1e9, "output.field_interval": -1, "output.history_interval": 1e3}
long = service.submit(job_file, set=endless)
for _ in range(2):
    while long.refresh().state != "running":
        time.sleep(0.1)
    assert long.stop().about["stopping"]
    long.wait(timeout=200, check=False)
    assert (long.state, long.code) == ("stopped", 130), long.about
    long.resume(workers=2)
assert long.about["workers"] == 2
assert [job.id for job in service.jobs(state="completed")] == [done.id]
long.stop()

# Errors have the message of the service.
bad = service.submit(job_file, set={"end_time": -1})
try:
    bad.wait(timeout=200)
    raise SystemExit("a job that cannot run was taken")
except crumple.ServiceJobError as error:
    assert "end_time" in str(error) and bad.state == "refused", error
for wrong, status, words in [
    (lambda: service.job(999), 404, "there is no job 999"),
    (lambda: done.stop(), 409, "completed already"),
    (lambda: service.submit(job_file, workers=100_000), 422, "workers: give 1 to"),
    (lambda: done.history("absent.csv"), 404, "no such file"),
    (lambda: crumple.Service(service.url, "0" * 64).jobs(), 401, "valid token"),
    (lambda: crumple.Service("http://127.0.0.1:1", "x").jobs(), None, "127.0.0.1:1"),
]:
    try:
        wrong()
        raise SystemExit(f"no error: {words}")
    except crumple.ServiceError as error:
        assert error.status == status and words in str(error), error
