"""Jobs, runs and results of Crumple, an explicit finite element solver for crash and impact.

    results = crumple.run("cases/bars", workers=2)
    history = results.history()
    stress = results.fields()["von_mises"]

`crumple.Service` submits jobs to a service (`crumple serve`).
"""

from typing import TYPE_CHECKING, Any

from ._native import VERSION as __version__
from .errors import Finding, JobError, RunError
from .fields import Fields
from .job import Check, Job, check
from .results import Report, Results, open
from .running import Progress, resume, run

if TYPE_CHECKING:
    from .service import Service, ServiceError
    from .service_job import FINAL_STATES, ServiceJob, ServiceJobError

OF_SERVICE = {
    "Service": "service",
    "ServiceError": "service",
    "FINAL_STATES": "service_job",
    "ServiceJob": "service_job",
    "ServiceJobError": "service_job",
}
"""Modules of the names that are imported when they are used: they need `requests`."""

__all__ = [
    "__version__",
    "Check",
    "FINAL_STATES",
    "Fields",
    "Finding",
    "Job",
    "JobError",
    "Progress",
    "Report",
    "Results",
    "RunError",
    "Service",
    "ServiceError",
    "ServiceJob",
    "ServiceJobError",
    "check",
    "open",
    "resume",
    "run",
]


def __getattr__(name: str) -> Any:
    from importlib import import_module

    if name in OF_SERVICE:
        return getattr(import_module(f".{OF_SERVICE[name]}", __name__), name)
    raise AttributeError(f"module {__name__} has no attribute {name}")
