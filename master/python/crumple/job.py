"""A job as nested tables, checked against the schema of jobs."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping, MutableMapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from . import _native
from ._options import changes
from .errors import Finding, JobError

FILES = ("file", "deck", "exodus")
"""Keys of `mesh` that name a file in the folder of the job."""
DECKS = (".k", ".key", ".dyn")


class Job(MutableMapping[str, Any]):
    """A job: a table of the keys of a job file, with tables and lists as in TOML.

        job = crumple.Job.read("cases/bars")
        job["end_time"] = 0.05
        job["part"][0]["thickness"] = 0.3
        job.write("bars/job.toml")

    Files that it names are in `folder`. The key and the type of a value are checked when it is
    set, values within a table when the job is written, checked or run.
    """

    def __init__(
        self,
        table: Mapping[str, Any] | None = None,
        *,
        folder: str | os.PathLike[str] = ".",
        name: str = "job",
    ) -> None:
        """Makes a job of a table.

        Raises `JobError` with all problems of its keys; keys that are missing are none yet.
        """
        self.folder = Path(folder)
        self.name = name
        self._table: dict[str, Any] = {}
        self._set({key: _plain(value) for key, value in (table or {}).items()})

    @classmethod
    def read(cls, path: str | os.PathLike[str]) -> Job:
        """Reads a job file, or `job.toml` in a folder; a deck becomes a job that names it.

        Raises `OSError`, `ValueError` if the file is no TOML, and `JobError`.
        """
        path = Path(path)
        file = path / "job.toml" if path.is_dir() else path
        name = file.resolve().parent.name if file.name == "job.toml" else file.stem
        if file.suffix.lower() in DECKS:
            return cls({"mesh": {"deck": file.name}}, folder=file.parent, name=name)
        try:
            table = _native.from_toml(file.read_text(encoding="utf-8"))
        except ValueError as error:
            raise ValueError(f"{file}: {error}") from None
        return cls(table, folder=file.parent, name=name)

    @classmethod
    def example(cls, name: str) -> Job:
        """Returns an example job, of those of `crumple init` that need no file.

        Raises `KeyError` with the names of all examples.
        """
        known = dict(_native.examples())
        if name not in known:
            raise KeyError(f"there is no example {name}; there are {', '.join(known)}")
        return cls(_native.from_toml(known[name]), name=name)

    @staticmethod
    def schema() -> dict[str, Any]:
        """Returns the JSON Schema of jobs."""
        schema: dict[str, Any] = json.loads(_native.schema())
        return schema

    def toml(self) -> str:
        """Returns the text of the job file."""
        return _native.to_toml(_plain(self._table))

    def problems(self) -> list[Finding]:
        """Returns all problems of its keys: unknown and missing ones, and wrong types.

        `crumple.check` also reads the meshes and checks the model.
        """
        return JobError.of_keys(_native.check_keys(self.toml())).findings

    def write(self, path: str | os.PathLike[str]) -> Path:
        """Writes the job file and returns its path.

        Names of files are changed so that they hold in the folder of `path`. Raises `JobError`
        with all problems of its keys.
        """
        if found := _native.check_keys(self.toml()):
            raise JobError.of_keys(found)
        path = Path(path)
        path.parent.mkdir(parents=True, exist_ok=True)
        moved = Job(self._table)
        here = path.parent.resolve()

        def moved_to(name: str) -> str:
            return os.path.relpath((self.folder / name).resolve(), here)

        mesh = moved._table.get("mesh", {})
        for key in FILES:
            if key in mesh:
                mesh[key] = moved_to(mesh[key])
        for added in mesh.get("add", []):
            added["file"] = moved_to(added["file"])
        if "include" in moved._table:
            moved._table["include"] = [moved_to(name) for name in moved._table["include"]]
        path.write_text(moved.toml(), encoding="utf-8")
        return path

    def copy(self) -> Job:
        """Returns a job that shares nothing with this one."""
        return Job(self._table, folder=self.folder, name=self.name)

    def _set(self, values: Mapping[str, Any]) -> None:
        """Sets values after a check of each; of missing keys only those within them count."""
        found = _native.check_keys(_native.to_toml(_plain({**self._table, **values})))
        own = [one for one in found if one[0].split(".")[0] in values]
        if own:
            raise JobError.of_keys(own)
        self._table.update(values)

    def __getitem__(self, key: str) -> Any:
        return self._table[key]

    def __setitem__(self, key: str, value: Any) -> None:
        self._set({key: _plain(value)})

    def __delitem__(self, key: str) -> None:
        del self._table[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self._table)

    def __len__(self) -> int:
        return len(self._table)

    def __repr__(self) -> str:
        return f"<Job {self.name!r}: {', '.join(self)}>"


@dataclass(frozen=True)
class Check:
    """A job that can run, as `crumple check` describes it."""

    text: str
    """Mass, parts, time step, mesh quality and cost."""
    warnings: list[Finding]
    """Warnings."""
    memory_mb: float
    """Estimated memory [MB]."""

    def __str__(self) -> str:
        return self.text


def check(
    job: Job | str | os.PathLike[str],
    *,
    workers: int | None = None,
    set: Mapping[str, object] | None = None,
) -> Check:
    """Checks a job, its meshes and its model, without running it.

    `job` is a job, a job file, a folder with `job.toml`, or a deck. Raises `JobError` with all
    problems.
    """
    text = job.toml() if isinstance(job, Job) else None
    path = job.folder / "job.toml" if isinstance(job, Job) else Path(job)
    found = _native.check_job(os.fspath(path), text, changes(set), workers)
    if not found["usable"]:
        raise JobError(found)
    warnings = [Finding.of(one) for one in found["findings"]]
    return Check(found["text"], warnings, found["memory_mb"])


def _plain(value: Any) -> Any:
    """Returns a value with tables, lists and numbers of Python in place of those of NumPy."""
    if isinstance(value, Mapping):
        return {str(key): _plain(one) for key, one in value.items()}
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, (list, tuple)):
        return [_plain(one) for one in value]
    return os.fspath(value) if isinstance(value, os.PathLike) else value
