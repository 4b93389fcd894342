"""A client of `rangeface serve`, with nothing but the standard library.

It may be imported where the service is not installed::

    from rangeface.client import Client

    with Client("http://127.0.0.1:8787", key_file="rangeface.key") as door:
        print(door.identify("probe.npz").subject)
"""

from __future__ import annotations

import http.client
import json
import ssl
import time
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import date
from pathlib import Path
from typing import Any, Self
from urllib.parse import urlencode, urlsplit

from rangeface.errors import ParameterError, RangeFaceError
from rangeface.types import Camera, Decision, Reason, Verdict

Scan = str | Path | bytes

_IDLE_S = 15.0  # the service hangs up after 30 s


class ServiceError(RangeFaceError):
    """The service said no, or could not be reached.

    Parameters
    ----------
    status : int
        HTTP status; 0 where there was no answer.
    reason : str
        From the service's closed list, such as "wrong-scope", or "unreachable".
    detail : str
        This case, in a sentence.
    why : str, optional
        Of a scan: its `ScanFault`; of a face: its `Reason`.
    retry_s : float, optional
        When to try again, s.
    """

    def __init__(
        self,
        status: int,
        reason: str,
        detail: str = "",
        *,
        why: str | None = None,
        retry_s: float | None = None,
    ) -> None:
        self.status, self.reason, self.detail = status, reason, detail
        self.why, self.retry_s = why, retry_s
        super().__init__(": ".join(filter(None, (reason, why, detail))))


@dataclass(frozen=True)
class Person:
    """Somebody who is enrolled.

    Parameters
    ----------
    subject : str
    consent : str, optional
        Reference of the consent.
    expires : date, optional
        Its last day.
    """

    subject: str
    consent: str | None
    expires: date | None


class Client:
    """One connection to a service; not for several threads at a time.

    Parameters
    ----------
    url : str
        ``http://127.0.0.1:8787``, or ``https://…``.
    key : str, optional
        The key.
    key_file : str or Path, optional
        File that holds it, in place of `key`.
    timeout_s : float
        Longest wait for an answer, s.
    tls : ssl.SSLContext, optional
        For certificates that the system does not trust.

    Raises
    ------
    ParameterError
        The address is none, or there is no key.
    ServiceError
        The service refused, or could not be reached.
    """

    def __init__(
        self,
        url: str,
        *,
        key: str | None = None,
        key_file: str | Path | None = None,
        timeout_s: float = 30.0,
        tls: ssl.SSLContext | None = None,
    ) -> None:
        parts = urlsplit(url)
        if parts.scheme not in ("http", "https") or not parts.hostname:
            raise ParameterError(f"url: need http://HOST:PORT or https://HOST:PORT, got {url!r}")
        if (key is None) == (key_file is None):
            raise ParameterError("key, key_file: give one of them")
        self._key = key if key_file is None else Path(key_file).read_text("ascii").strip()
        self._used = 0.0
        if parts.scheme == "https":
            self._connection: http.client.HTTPConnection = http.client.HTTPSConnection(
                parts.hostname, parts.port, timeout=timeout_s, context=tls
            )
        else:
            self._connection = http.client.HTTPConnection(
                parts.hostname, parts.port, timeout=timeout_s
            )

    def identify(
        self, scan: Scan, *, camera: Camera | None = None, unit: str | None = None
    ) -> Decision:
        """Ask who a scan shows.

        Parameters
        ----------
        scan : str, Path or bytes
            The file, or its contents, in any format that `rangeface info` reads.
        camera : Pinhole or Orthographic, optional
            Of a depth image that brings none.
        unit : str, optional
            Of a file that states none.

        Returns
        -------
        Decision
            Scores are NaN unless the key has the scope *scores*.
        """
        return _decision(self._scan("POST", "/v1/identify", scan, camera, unit))

    def verify(
        self, subject: str, scan: Scan, *, camera: Camera | None = None, unit: str | None = None
    ) -> Decision:
        """Ask whether a scan shows the person it claims to; else as `identify`."""
        return _decision(self._scan("POST", "/v1/verify", scan, camera, unit, subject=subject))

    def enroll(
        self,
        subject: str,
        scan: Scan,
        *,
        consent: str | None = None,
        expires: date | None = None,
        camera: Camera | None = None,
        unit: str | None = None,
    ) -> int:
        """Enrol a person, or add a template; gives the number of people.

        Parameters
        ----------
        subject : str
            The person's name.
        scan, camera, unit
            As in `identify`.
        consent : str, optional
            Reference of the consent.
        expires : date, optional
            Its last day.

        Returns
        -------
        int
            People enrolled now. The template is safe on the service's disk.
        """
        answer = self._scan(
            "POST", "/v1/people", scan, camera, unit,
            subject=subject, consent=consent, expires=expires,
        )  # fmt: skip
        return int(answer["people"])

    def delete(self, subject: str) -> int:
        """Delete a person; gives the number of templates that were."""
        return int(self._ask("DELETE", "/v1/people", {"subject": subject})["templates"])

    def people(self) -> list[Person]:
        """Who is enrolled, in the order of enrolment."""
        found: list[Person] = []
        while True:
            page = self._ask("GET", "/v1/people", {"offset": len(found), "limit": 1000})
            found += map(_person, page["people"])
            if not page["people"] or len(found) >= page["total"]:
                return found

    def status(self) -> dict[str, Any]:
        """What is served: version, model, fmr, threshold, people, workers, waiting."""
        return self._ask("GET", "/v1/status")

    def close(self) -> None:
        """Let go of the connection."""
        self._connection.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *failure: object) -> None:
        self.close()

    def _scan(
        self, method: str, path: str, scan: Scan, camera: Camera | None, unit: str | None,
        **query: object,
    ) -> dict[str, Any]:  # fmt: skip
        body = scan if isinstance(scan, bytes) else Path(scan).read_bytes()
        return self._ask(method, path, {**query, "unit": unit, **_parameters(camera)}, body)

    def _ask(
        self, method: str, path: str, query: Mapping[str, object] | None = None,
        body: bytes | None = None,
    ) -> dict[str, Any]:  # fmt: skip
        given = {k: str(v) for k, v in (query or {}).items() if v is not None}
        headers = {"Authorization": f"Bearer {self._key}", "Accept": "application/json"}
        if body is not None:
            headers["Content-Type"] = "application/octet-stream"
        if time.monotonic() - self._used > _IDLE_S:
            self._connection.close()
        try:
            self._connection.request(method, f"{path}?{urlencode(given)}", body, headers)
            response = self._connection.getresponse()
            status, retry, text = response.status, response.headers["Retry-After"], response.read()
            self._used = time.monotonic()
        except (OSError, http.client.HTTPException) as error:
            self._connection.close()
            raise ServiceError(0, "unreachable", str(error) or type(error).__name__) from error
        return _checked(status, retry, text)


def _parameters(camera: Camera | None) -> dict[str, float]:
    """A camera as the query's parameters."""
    return {} if camera is None else dict(vars(camera))


def _checked(status: int, retry: str | None, text: bytes) -> dict[str, Any]:
    try:
        answer = json.loads(text)
    except ValueError:
        raise ServiceError(status, "no-answer", "is this a rangeface service?") from None
    if status >= 400:
        raise ServiceError(
            status,
            answer.get("reason", "unknown"),
            answer.get("detail", ""),
            why=answer.get("why"),
            retry_s=float(retry) if retry else None,
        )
    return dict(answer)


def _decision(answer: dict[str, Any]) -> Decision:
    nan = float("nan")
    return Decision(
        Verdict(answer["verdict"]),
        answer["subject"],
        nan if answer["score"] is None else answer["score"],
        nan if answer["threshold"] is None else answer["threshold"],
        Reason(answer["reason"]) if answer["reason"] else None,
        tuple((entry["subject"], entry["score"]) for entry in answer["ranking"] or ()),
    )


def _person(entry: dict[str, Any]) -> Person:
    expires = entry["expires"]
    return Person(
        entry["subject"], entry["consent"], date.fromisoformat(expires) if expires else None
    )
