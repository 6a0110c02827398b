"""A service, and the submission of jobs to it."""

from __future__ import annotations

import json
import os
import secrets
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import quote

from ._optional import missing
from ._options import changes

try:
    import requests
except ImportError as error:
    raise missing("requests") from error

if TYPE_CHECKING:
    from .service_job import ServiceJob

ARCHIVES = (".zip", ".tar", ".tar.gz", ".tgz")
PIECE = 1 << 20
"""Size of the pieces in which files are copied [byte]."""


class ServiceError(Exception):
    """The service refuses a request, or does not answer; the text is its reason.

    `status` is the status code of HTTP, or none without an answer.
    """

    def __init__(self, reason: str, status: int | None = None) -> None:
        super().__init__(reason)
        self.status = status


class Service:
    """A service at `url`, such as `http://127.0.0.1:8787`, reached with a token.

    `ca` is a file with the certificates (PEM) that are trusted, such as that of a private
    authority; without it, public authorities are. `timeout` is the longest pause of the service
    within an answer [s].
    """

    def __init__(
        self,
        url: str,
        token: str,
        *,
        ca: str | os.PathLike[str] | None = None,
        timeout: float = 150.0,
    ) -> None:
        self.url = url.rstrip("/")
        self._timeout = timeout
        self._session = requests.Session()
        # Neither proxies nor passwords of the environment are meant for the service.
        self._session.trust_env = False
        self._session.headers["Authorization"] = f"Bearer {token}"
        if ca is not None:
            self._session.verify = os.fspath(ca)

    @classmethod
    def in_folder(
        cls,
        folder: str | os.PathLike[str] = "out/service",
        *,
        ca: str | os.PathLike[str] | None = None,
    ) -> Service:
        """Returns the service of this machine whose folder is `folder` (`crumple serve --dir`)."""
        access = json.loads((Path(folder) / "access.json").read_text())
        return cls(access["address"], access["token"], ca=ca)

    def submit(
        self,
        path: str | os.PathLike[str],
        *,
        workers: int = 1,
        priority: int = 0,
        name: str = "",
        main: str = "",
        launcher: str = "",
        retries: int = 2,
        set: Mapping[str, object] | None = None,
        check_only: bool = False,
    ) -> ServiceJob:
        """Submits a job file, a folder with all its files, or an archive (zip, tar, tar.gz).

        `main` names the job file in a folder or an archive. `set` has changes of the job, such as
        `{"end_time": 40.0}`. With `check_only`, the job starts when it is resumed.
        """
        from .service_job import ServiceJob

        options = {
            "name": name,
            "job": main,
            "workers": workers,
            "launcher": launcher,
            "priority": priority,
            "retries": retries,
            "set": changes(set),
            "check_only": check_only,
        }
        boundary = secrets.token_hex(20)
        kind = {"Content-Type": f"multipart/form-data; boundary={boundary}"}
        form = _form(boundary, options, Path(path))
        return ServiceJob(self, self._json("POST", "/api/jobs", data=form, headers=kind))

    def job(self, number: int) -> ServiceJob:
        """Returns a job."""
        from .service_job import ServiceJob

        return ServiceJob(self, self._json("GET", f"/api/jobs/{number}"))

    def jobs(self, *, state: str | None = None, limit: int = 100) -> list[ServiceJob]:
        """Returns the newest jobs, at most `limit`; with `state`, only those in it."""
        from .service_job import ServiceJob

        query: dict[str, str | int] = {"limit": limit}
        if state is not None:
            query["state"] = state
        page = self._json("GET", "/api/jobs", params=query)
        return [ServiceJob(self, about) for about in page["jobs"]]

    def _json(self, method: str, path: str, **arguments: Any) -> Any:
        return self._ask(method, path, **arguments).json()

    def _download(self, job: int, path: str) -> Iterator[bytes]:
        """Yields the pieces of a file of a job."""
        url = f"/api/jobs/{job}/files/{quote(path)}"
        with self._ask("GET", url, stream=True) as response:
            try:
                yield from response.iter_content(PIECE)
            except requests.RequestException as error:
                raise ServiceError(f"{self.url}: {path} was cut off: {error}") from error

    def _ask(self, method: str, path: str, **arguments: Any) -> requests.Response:
        try:
            response = self._session.request(
                method, self.url + path, timeout=self._timeout, allow_redirects=False, **arguments
            )
        except requests.RequestException as error:
            raise ServiceError(f"{self.url}: {error}") from error
        if response.ok:
            return response
        try:
            reason = str(response.json()["error"])
        except (ValueError, KeyError, TypeError):
            reason = f"{self.url}: status {response.status_code}"
        raise ServiceError(reason, response.status_code)


def _form(boundary: str, options: Mapping[str, object], path: Path) -> Iterator[bytes]:
    """Yields a form with options and files. That of `requests` would be in memory as a whole."""
    part = f'--{boundary}\r\nContent-Disposition: form-data; name="'
    yield f'{part}options"\r\n\r\n{json.dumps(options)}\r\n'.encode()
    for kind, name, path_of_file in _files(path):
        plain = name.replace('"', "%22").replace("\r", " ").replace("\n", " ")
        yield f'{part}{kind}"; filename="{plain}"\r\n\r\n'.encode()
        with path_of_file.open("rb") as file:
            while piece := file.read(PIECE):
                yield piece
        yield b"\r\n"
    yield f"--{boundary}--\r\n".encode()


def _files(path: Path) -> Iterator[tuple[str, str, Path]]:
    """Yields part of the form, name and path of all files of a job."""
    if path.is_dir():
        for file in sorted(path.rglob("*")):
            name = file.relative_to(path)
            if file.is_file() and not any(part.startswith(".") for part in name.parts):
                yield "file", name.as_posix(), file
    elif path.name.lower().endswith(ARCHIVES):
        yield "archive", path.name, path
    else:
        yield "file", path.name, path
