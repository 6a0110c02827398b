"""Exceptions, and the findings of a check."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .results import Results


@dataclass(frozen=True)
class Finding:
    """An error or a warning about a job."""

    severity: str
    """`error` or `warning`."""
    message: str
    """The problem, with the name of the entity."""
    help: str = ""
    """What to do; empty if there is nothing."""
    file: str | None = None
    """File with the line at fault."""
    line: int | None = None
    """Line, from 1."""
    column: int | None = None
    """Column in characters, from 1."""
    text: str | None = None
    """The line, or the part of it around the column."""
    key: str | None = None
    """Key at fault, such as `part.0.thickness`; known if only keys were checked."""
    change: str | None = None
    """Argument `set` at fault, as `key=value`."""

    @classmethod
    def of(cls, found: Mapping[str, Any]) -> Finding:
        """Returns a finding as `crumple check --json` prints it."""
        place = found["place"] or {}
        return cls(
            severity=found["severity"],
            message=found["message"],
            help=found["help"],
            file=place.get("file"),
            line=place.get("line"),
            column=place.get("column"),
            text=place.get("text"),
            change=found["set"],
        )

    def __str__(self) -> str:
        at = f"{self.file}:{self.line}: " if self.file else f"{self.key}: " if self.key else ""
        return f"{self.severity}: {at}{self.message}" + (f" ({self.help})" if self.help else "")


class JobError(Exception):
    """A job cannot run. `findings` has all its problems, errors first."""

    def __init__(self, found: Mapping[str, Any]) -> None:
        """Takes the object that `crumple check --json` prints."""
        super().__init__(str(found["text"]).rstrip())
        self.findings = [Finding.of(one) for one in found["findings"]]

    @classmethod
    def of_keys(cls, problems: list[tuple[str, str, str]]) -> JobError:
        """Returns the exception for problems of keys: path, message and remedy of each."""
        findings = [Finding("error", message, help, key=path) for path, message, help in problems]
        error = cls({"text": "\n".join(map(str, findings)), "findings": []})
        error.findings = findings
        return error


class RunError(Exception):
    """A run cannot begin, was lost, or has failed.

    `results` are those of a run that has failed; without a summary there are none.
    """

    def __init__(self, reason: str, results: Results | None = None) -> None:
        super().__init__(reason)
        self.results = results
