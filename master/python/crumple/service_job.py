"""A job of a service: its state, orders to it, and its results."""

from __future__ import annotations

import io
import os
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree

from ._optional import module
from ._options import changes
from .service import Service

if TYPE_CHECKING:
    import pandas
    import pyvista

FINAL_STATES = frozenset({"checked", "completed", "refused", "failed", "lost", "stopped"})
"""States in which nothing more happens without an order."""


class ServiceJobError(Exception):
    """A job has ended in another way than asked for; the text is the reason of the service."""

    def __init__(self, job: ServiceJob) -> None:
        super().__init__(f"job {job.id} is {job.state}: {job.reason or 'no reason is known'}")
        self.job = job


class ServiceJob:
    """A job. Its attributes are as of the last answer of the service; `refresh` asks again."""

    def __init__(self, service: Service, about: Mapping[str, Any]) -> None:
        self._service = service
        self._about = about

    def __repr__(self) -> str:
        return f"<ServiceJob {self.id} {self.name!r}: {self.state}>"

    @property
    def id(self) -> int:
        """Number."""
        return int(self._about["id"])

    @property
    def name(self) -> str:
        """Name that its owner gave it."""
        return str(self._about["name"])

    @property
    def state(self) -> str:
        """`queued`, `running`, `completed` and so on."""
        return str(self._about["state"])

    @property
    def reason(self) -> str:
        """Why it is in this state."""
        return str(self._about["reason"])

    @property
    def code(self) -> int | None:
        """Exit code of its run; none before its end."""
        code = self._about["code"]
        return None if code is None else int(code)

    @property
    def about(self) -> Mapping[str, Any]:
        """All that the service knows of it, as in the description of its interface."""
        return self._about

    def refresh(self) -> ServiceJob:
        """Asks for its present state."""
        self._about = self._service._json("GET", f"/api/jobs/{self.id}")
        return self

    def wait(
        self, *, timeout: float | None = None, every: float = 0.5, check: bool = True
    ) -> ServiceJob:
        """Waits until it ends, at most `timeout` seconds, and asks `every` so many seconds.

        Raises `ServiceJobError` if it is neither complete nor checked, unless `check` is false,
        and `TimeoutError`.
        """
        end = None if timeout is None else time.monotonic() + timeout
        while self.refresh().state not in FINAL_STATES:
            if end is not None and time.monotonic() > end:
                raise TimeoutError(f"job {self.id} is still {self.state} after {timeout} s")
            time.sleep(every)
        if check and self.state not in ("completed", "checked"):
            raise ServiceJobError(self)
        return self

    def stop(self, *, force: bool = False) -> ServiceJob:
        """Stops it: one that waits never starts, one that runs writes a checkpoint.

        With `force`, a job that was asked before and does not stop is killed.
        """
        path = f"/api/jobs/{self.id}/stop?force={str(force).lower()}"
        self._about = self._service._json("POST", path, json={})
        return self

    def resume(
        self, *, workers: int | None = None, set: Mapping[str, object] | None = None
    ) -> ServiceJob:
        """Starts one that was only checked, or continues one from its newest checkpoint."""
        change: dict[str, object] = {"set": changes(set)}
        if workers is not None:
            change["workers"] = workers
        self._about = self._service._json("POST", f"/api/jobs/{self.id}/resume", json=change)
        return self

    def findings(self) -> str:
        """Returns what `crumple check` says of it."""
        return str(self._service._json("GET", f"/api/jobs/{self.id}/check")["text"])

    def files(self) -> dict[str, int]:
        """Returns the sizes of its files [byte] by their paths."""
        all = self._service._json("GET", f"/api/jobs/{self.id}/files")
        return {str(file["path"]): int(file["size"]) for file in all}

    def read(self, path: str) -> bytes:
        """Returns the content of a file, such as `results/summary.json`."""
        return b"".join(self._service._download(self.id, path))

    def history(self, name: str = "history.csv") -> pandas.DataFrame:
        """Returns a history: one row per time, and columns with units as in the file."""
        pandas = module("pandas")
        text = io.BytesIO(self.read(f"results/{name}"))
        return pandas.read_csv(text, float_precision="round_trip")

    def times(self) -> list[float]:
        """Returns the times of its fields, in the unit of the job."""
        return [time for time, _ in self._steps()]

    def fields(self, step: int = -1) -> pyvista.UnstructuredGrid:
        """Returns the fields of one output step, the last one unless `step` says otherwise.

        Raises `ImportError` without PyVista.
        """
        vista = module("pyvista")
        steps = self._steps()
        try:
            _, index = steps[step]
        except IndexError:
            raise IndexError(f"job {self.id} has {len(steps)} steps with fields") from None
        folder = str(PurePosixPath("results/fields", index).parent)
        with tempfile.TemporaryDirectory() as copy:
            self.fetch(copy, only=f"{folder}/")
            grid: pyvista.UnstructuredGrid = vista.read(Path(copy) / "results/fields" / index)
        is_mesh = isinstance(grid, vista.UnstructuredGrid)
        if not is_mesh:
            raise TypeError(f"{index} has {type(grid).__name__} instead of a mesh")
        return grid

    def fetch(
        self, folder: str | os.PathLike[str] | None = None, *, only: str = "results/"
    ) -> Path:
        """Copies the files whose paths begin with `only` into a folder, and returns the folder.

        Without `folder`, it is `out/job-` and the number.
        """
        target = Path(folder if folder is not None else f"out/job-{self.id}")
        paths = [path for path in self.files() if path.startswith(only)]
        if not paths:
            raise FileNotFoundError(f"job {self.id} has no file whose path begins with {only}")
        for path in paths:
            if not all(part not in ("", ".", "..") for part in path.split("/")):
                raise ValueError(f"{path}: the service names a file outside its folder")
            file = target / path
            file.parent.mkdir(parents=True, exist_ok=True)
            part = file.with_name(file.name + ".part")
            with part.open("wb") as out:
                out.writelines(self._service._download(self.id, path))
            part.replace(file)
        return target

    def _steps(self) -> list[tuple[float, str]]:
        """Returns times and files of its fields."""
        text = self.read("results/fields/fields.pvd")
        sets = ElementTree.fromstring(text).iter("DataSet")
        return [(float(one.attrib["timestep"]), one.attrib["file"]) for one in sets]
