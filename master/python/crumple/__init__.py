"""Client of a Crumple service (`crumple serve`).

    service = crumple.Service.in_folder("out/service")
    job = service.submit("cases/jeep-frame", workers=2).wait()
    history = job.history()
"""

from .job import FINAL_STATES, Job, JobError
from .service import Service, ServiceError

__all__ = ["FINAL_STATES", "Job", "JobError", "Service", "ServiceError"]
