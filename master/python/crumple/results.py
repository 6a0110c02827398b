"""Results of a run: summary, histories, fields and report."""

from __future__ import annotations

import html
import json
import logging
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import _native
from ._optional import module
from .fields import Fields

if TYPE_CHECKING:
    import pandas
    import pyvista

LOG = logging.getLogger("crumple")


class Results:
    """Results in a folder. Files are read when they are asked for."""

    def __init__(self, folder: str | os.PathLike[str]) -> None:
        self.folder = Path(folder)
        self._summary: dict[str, Any] | None = None

    @property
    def summary(self) -> dict[str, Any]:
        """How the run ended: one number per quantity, as in `summary.json`.

        Raises `OSError` while the run is in progress, and if it was lost.
        """
        if self._summary is None:
            summary: dict[str, Any] = json.loads((self.folder / "summary.json").read_text())
            self._summary = summary
        return self._summary

    @property
    def status(self) -> str:
        """`completed`, `stopped` or `failed`; `unfinished` without a summary."""
        try:
            return str(self.summary["status"])
        except OSError:
            return "unfinished"

    @property
    def warnings(self) -> list[str]:
        """What to look at before the results are used: the lines that the program prints.

        Folders of older versions have no lines: what was found and the setting that cures it.
        """
        line = "{what}. {cure}"
        return [one.get("message") or line.format(**one) for one in self.summary["warnings"]]

    @property
    def requirements(self) -> list[dict[str, Any]]:
        """Requirements of the job, with the value and the verdict of each.

        `is_met` is the verdict, `value` the number in `unit`, `time` that of an extreme.
        """
        return list(self.summary.get("requirements", []))

    @property
    def provenance(self) -> dict[str, Any]:
        """Program, machine, command, job and files that were read, as in `provenance.json`."""
        provenance: dict[str, Any] = json.loads((self.folder / "provenance.json").read_text())
        return provenance

    @property
    def tables(self) -> list[str]:
        """Names of the histories, such as `history` and `parts`."""
        return sorted(path.stem for path in self.folder.glob("*.csv"))

    def history(self, name: str = "history") -> pandas.DataFrame:
        """Returns a history: one row per time, and columns with units as in the file.

        Raises `FileNotFoundError` with the names that there are, and `ImportError` without
        pandas.
        """
        pandas = module("pandas")
        path = self.folder / f"{name.removesuffix('.csv')}.csv"
        if not path.is_file():
            there = ", ".join(self.tables) or "no history"
            raise FileNotFoundError(f"{path} does not exist; the folder has {there}")
        # The default of pandas is off in the last bit.
        return pandas.read_csv(path, float_precision="round_trip")

    @property
    def times(self) -> list[float]:
        """Times of the fields, in the unit of the job; empty without fields."""
        return [time for time, _ in self._steps()]

    def fields(self, step: int = -1) -> Fields:
        """Returns the fields of one output step as NumPy arrays, the last one by default.

        Raises `IndexError` if there is no such step, and `ValueError` if a file is damaged.
        """
        steps = self._steps()
        try:
            time, file = steps[step]
        except IndexError:
            raise IndexError(f"{self.folder} has {len(steps)} steps with fields") from None
        return Fields.read(time, file)

    def grid(self, step: int = -1) -> pyvista.UnstructuredGrid:
        """Returns the fields of one output step for PyVista, the last one by default."""
        return self.fields(step).grid()

    @property
    def report(self) -> Report:
        """The report page, which a notebook shows.

        Raises `FileNotFoundError` if the run has made none.
        """
        return Report(self.folder / "report.html")

    def _steps(self) -> list[tuple[float, str]]:
        if not (self.folder / "fields" / "fields.pvd").is_file():
            return []
        return _native.steps(os.fspath(self.folder))

    def __repr__(self) -> str:
        return f"<Results {os.fspath(self.folder)!r}: {self.status}>"

    def _repr_html_(self) -> str:
        """Returns a table of the summary, for notebooks."""
        if self.status == "unfinished":
            return html.escape(repr(self))
        about = self.summary
        rows = {
            "status": f"{about['status']}, {about['reason']}",
            "time": f"{about['end_time']:.6g}, {about['cycles']} cycles",
            "model": f"{about['nodes']} nodes, {sum(about['elements'].values())} elements",
            "run": f"{about['workers']} workers, {about['wall_s']:.1f} s",
            "energy error": f"{100 * about['energy']['error_max']:.3f} % at most",
            "warnings": "; ".join(self.warnings) or "none",
            "requirements": "; ".join(verdict(one) for one in self.requirements) or "none",
            "folder": os.fspath(self.folder),
        }
        lines = (
            f"<tr><th>{html.escape(name)}</th><td>{html.escape(value)}</td></tr>"
            for name, value in rows.items()
        )
        title = html.escape(about["title"] or self.folder.name)
        return f"<table><caption>{title}</caption>{''.join(lines)}</table>"


class Report:
    """The report page of a run. A notebook shows it as a frame."""

    def __init__(self, path: str | os.PathLike[str], *, height: int = 700) -> None:
        self.path = Path(path)
        self.height = height
        if not self.path.is_file():
            raise FileNotFoundError(f"{path} does not exist; `crumple report` makes it")

    def __repr__(self) -> str:
        return f"<Report {os.fspath(self.path)!r}>"

    def _repr_html_(self) -> str:
        """Returns the page within a frame, so that its styles and scripts stay its own."""
        page = html.escape(self.path.read_text(encoding="utf-8"))
        style = f"width:100%;height:{self.height}px;border:0"
        return f'<iframe srcdoc="{page}" style="{style}"></iframe>'


def verdict(requirement: dict[str, Any]) -> str:
    """Returns a requirement as one line: `FAIL  name: value unit (required: limits)`."""
    word = "PASS" if requirement["is_met"] else "FAIL"
    value = requirement["value"]
    if value is None:
        found = str(requirement.get("why", "no value"))
    else:
        found = f"{value:.6e} {requirement.get('unit', '')}".rstrip()
        if requirement.get("time") is not None:
            unit = requirement.get("unit_of_time", "")
            found += f" at time {requirement['time']:.4e} {unit}".rstrip()
    sides = [(side, requirement[side]) for side in ("below", "above")]
    limits = ", ".join(f"{side} {limit:.10g}" for side, limit in sides if limit is not None)
    return f"{word}  {requirement['name']}: {found} (required: {limits})"


def open(folder: str | os.PathLike[str]) -> Results:
    """Opens the results in a folder.

    Each requirement that is not met is a warning of the logger `crumple`.

    Raises `FileNotFoundError` if there are none.
    """
    results = Results(folder)
    if not (results.folder / "history.csv").is_file():
        raise FileNotFoundError(f"{results.folder} has no results of a run")
    if results.status != "unfinished":
        for requirement in results.requirements:
            if not requirement["is_met"]:
                LOG.warning("%s", verdict(requirement))
    return results
