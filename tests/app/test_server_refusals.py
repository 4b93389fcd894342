"""Whom the service does not let in, and what it survives."""

from __future__ import annotations

import os
import signal
import socket
import sqlite3
import time
from contextlib import closing, suppress
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
from serving import Served

from rangeface.app.server.keys import KeyRing, Scope
from rangeface.app.server.run import check_address, first_key
from rangeface.app.server.settings import Settings
from rangeface.errors import GalleryError, ParameterError

ROUTES = [
    ("POST", "/v1/identify", Scope.IDENTIFY),
    ("POST", "/v1/verify?subject=ann", Scope.VERIFY),
    ("POST", "/v1/people?subject=eve", Scope.ENROLL),
    ("GET", "/v1/people", Scope.LIST),
    ("DELETE", "/v1/people?subject=ann", Scope.DELETE),
    ("GET", "/v1/audit", Scope.ADMIN),
    ("GET", "/v1/status", Scope.STATUS),
    ("GET", "/metrics", Scope.STATUS),
    ("DELETE", "/v1/attempts", Scope.ADMIN),
]
OPEN = {"/healthz", "/readyz"}


# ── keys ─────────────────────────────────────────────────────────────────────────────────


def test_the_matrix_below_knows_every_route(served):
    _, document = served.ask("GET", "/openapi.json")
    described = {
        (method.upper(), path)
        for path, methods in document["paths"].items()
        for method in methods
        if path not in OPEN
    }
    assert described == {(method, path.partition("?")[0]) for method, path, _ in ROUTES}


@pytest.mark.parametrize(("method", "path", "scope"), ROUTES)
def test_every_route_refuses_no_wrong_expired_and_unfit_keys(served, method, path, scope):
    yesterday = datetime.now(UTC) - timedelta(days=1)
    others = set(Scope) - {scope}
    for key, status, reason in (
        (None, 401, "missing-key"),
        ("nonsense", 401, "wrong-key"),
        (served.key[:-1], 401, "wrong-key"),
        (served.key.replace("rf.", "xx."), 401, "wrong-key"),
        (served.new_key(*Scope, expires=yesterday), 401, "expired-key"),
        (served.new_key(*others), 403, "wrong-scope"),
    ):
        found, headers, problem = served.ask_headers(method, path, b"x", key=key)
        assert (found, problem["reason"]) == (status, reason)
        assert headers["content-type"] == "application/problem+json"
        assert ("www-authenticate" in headers) == (status == 401)
    assert "ann" in [p["subject"] for p in served.ask("GET", "/v1/people")[1]["people"]]


def test_a_revoked_key_is_refused_at_once(served):
    key = served.new_key(Scope.LIST)
    assert served.ask("GET", "/v1/people", key=key)[0] == 200
    served.keys.revoke(key.split(".")[1])
    assert served.ask("GET", "/v1/people", key=key)[1]["reason"] == "wrong-key"


def test_the_first_key_is_random_and_nobody_else_reads_it(tmp_path):
    texts = set()
    for name in ("a", "b"):
        place = first_key(tmp_path / f"{name}.keys")
        assert place is not None
        for file in (place, tmp_path / f"{name}.keys"):
            assert file.stat().st_mode & 0o777 == 0o600
        text = place.read_text().strip()
        assert KeyRing(tmp_path / f"{name}.keys").find(text).scopes == set(Scope)
        assert text.split(".")[2] not in (tmp_path / f"{name}.keys").read_text()
        texts.add(text)
    assert len(texts) == 2
    assert first_key(tmp_path / "a.keys") is None


def test_a_broken_file_of_keys_opens_nothing(tmp_path):
    (tmp_path / "k").write_text("{}")
    with pytest.raises(ParameterError, match="no file of keys"):
        KeyRing(tmp_path / "k").find("rf.a.b")
    with pytest.raises(ParameterError, match="no key"):
        KeyRing(tmp_path / "none").revoke("a")


# ── addresses ────────────────────────────────────────────────────────────────────────────


@pytest.mark.parametrize("host", ["0.0.0.0", "::", "192.0.2.1", "door.example", ""])
def test_a_public_address_needs_tls(host):
    with pytest.raises(ParameterError, match="--tls-certificate"):
        check_address(host, None, None)
    check_address(host, Path("c.pem"), Path("k.pem"))


def test_half_of_tls_is_none():
    check_address("127.0.0.1", None, None)
    check_address("::1", None, None)
    check_address("localhost", None, None)
    with pytest.raises(ParameterError, match="certificate and its key"):
        check_address("127.0.0.1", Path("c.pem"), None)


@pytest.mark.parametrize("change", [{"fmr": 0.0}, {"fmr": 1.0}, {"workers": 0}, {"body_s": -1.0}])
def test_impossible_settings(change):
    with pytest.raises(ParameterError, match=next(iter(change))):
        Settings(keys=Path("k"), **change)


# ── attempts ─────────────────────────────────────────────────────────────────────────────


def test_five_failures_bring_a_pause_and_more_a_stop(served, scan_of):
    """Settings of the test: a pause of 0.5 s in place of 30, the stop at 12 in place of 50."""
    key = served.new_key(Scope.IDENTIFY)
    stranger, friend = scan_of(7), scan_of(1, 1)

    def answer(scan: bytes) -> str:
        status, found = served.ask("POST", "/v1/identify", scan, key=key)
        return found["verdict"] if status == 200 else found["reason"]

    for _ in range(4):
        assert answer(stranger) == "unknown"
    assert answer(friend) == "accepted"  # a success ends the row
    for _ in range(2):
        assert [answer(stranger) for _ in range(5)] == ["unknown"] * 5
        status, headers, problem = served.ask_headers("POST", "/v1/identify", friend, key=key)
        assert (status, problem["reason"]) == (429, "too-many-failures")
        assert int(headers["retry-after"]) >= 1
        time.sleep(0.6)
    assert [answer(stranger) for _ in range(2)] == ["unknown"] * 2
    assert answer(friend) == "attempts-stopped"
    assert served.ask("POST", "/v1/identify", friend)[0] == 200  # another key is not stopped
    assert served.ask("DELETE", "/v1/attempts")[1]["forgotten"] >= 1
    assert answer(friend) == "accepted"


def test_claims_of_a_name_are_counted_whatever_key_they_come_with(served, scan_of):
    for _ in range(5):
        key = served.new_key(Scope.VERIFY)
        assert served.ask("POST", "/v1/verify", scan_of(1), key=key, subject="bob")[0] == 200
    status, problem = served.ask("POST", "/v1/verify", scan_of(2), subject="bob")
    assert (status, problem["reason"]) == (429, "too-many-failures")
    assert served.ask("POST", "/v1/verify", scan_of(1, 2), subject="ann")[0] == 200
    served.ask("DELETE", "/v1/attempts")


# ── hostile clients ──────────────────────────────────────────────────────────────────────


def raw(served: Served, head: str, *pieces: bytes, pause_s: float = 0.0) -> bytes:
    """Send a head and pieces, slowly if asked; what came back until the service hung up."""
    with closing(socket.create_connection(("127.0.0.1", served.port), timeout=20)) as link:
        text = head.replace("KEY", served.key).replace("\n", "\r\n")
        try:
            link.sendall(text.encode())
            for piece in pieces:
                time.sleep(pause_s)
                link.sendall(piece)
        except OSError:  # it hung up already
            pass
        answer = b""
        try:
            while more := link.recv(1 << 16):
                answer += more
        except ConnectionResetError:
            pass
    return answer


HEAD = "POST /v1/identify HTTP/1.1\nHost: 127.0.0.1\nAuthorization: Bearer KEY\n"


def alive(served: Served) -> bool:
    return served.ask("GET", "/readyz", key=None)[0] == 200


def test_two_gigabytes_declared_are_refused_before_they_are_sent(served):
    start = time.monotonic()
    answer = raw(served, f"{HEAD}Content-Length: {2 << 30}\n\n")
    assert b"413" in answer.splitlines()[0]
    assert b"body-too-large" in answer
    assert time.monotonic() - start < 5
    assert alive(served)


def memory_mib(process: int) -> float:
    pages = int(Path(f"/proc/{process}/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 2**20


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="memory is read from /proc")
def test_two_gigabytes_streamed_are_cut_off(served):
    before = memory_mib(served.process.pid)
    chunk = b"100000\r\n" + bytes(1 << 20) + b"\r\n"
    head = f"{HEAD}Transfer-Encoding: chunked\n\n"
    answer = raw(served, head, *[chunk] * 2048)
    assert not answer or b"413" in answer.splitlines()[0]
    assert memory_mib(served.process.pid) - before < 64
    assert alive(served)


def test_a_body_that_dawdles_is_given_up(served):
    answer = raw(served, f"{HEAD}Content-Length: 100\n\n", *[b"x"] * 30, pause_s=0.1)
    assert b"408" in answer.splitlines()[0]
    assert b"body-too-slow" in answer


def test_a_head_that_dawdles_is_hung_up_on(served):
    start = time.monotonic()
    assert raw(served, "POST /v1/identify HTTP/1.1\nHo") == b""
    assert time.monotonic() - start < 5
    assert raw(served, "") == b""
    first = "GET /healthz HTTP/1.1\nHost: 127.0.0.1\n\nGET /healthz HT"
    answer = raw(served, first)  # the second of a connection must come in time, too
    assert answer.count(b"200 OK") == 1
    assert alive(served)


def test_many_slow_clients_leave_it_answering(served):
    links = [socket.create_connection(("127.0.0.1", served.port)) for _ in range(100)]
    try:
        for link in links:
            link.sendall(b"POST /v1/identify HTTP/1.1\r\nHost: 127.0.0.1\r\n")
        start = time.monotonic()
        assert alive(served)
        assert time.monotonic() - start < 5
    finally:
        for link in links:
            link.close()


@pytest.mark.parametrize(
    "text", [b"\x16\x03\x01\x02\x00\x01\x00", b"\x00" * 5000, b"GET " + b"a" * 70_000, b"\r\n" * 9]
)
def test_garbage_in_place_of_http(served, text):
    with closing(socket.create_connection(("127.0.0.1", served.port), timeout=20)) as link:
        link.sendall(text)
        link.shutdown(socket.SHUT_WR)
        with suppress(ConnectionResetError):
            assert link.recv(1 << 16)[:12] in (b"", b"HTTP/1.1 400")
    assert alive(served)


def test_who_hangs_up_before_the_answer_hurts_nobody(served, scan_of):
    scan = scan_of(1)
    for _ in range(5):
        with closing(socket.create_connection(("127.0.0.1", served.port))) as link:
            head = f"{HEAD}Content-Length: {len(scan)}\n\n".replace("KEY", served.key)
            link.sendall(head.replace("\n", "\r\n").encode() + scan)
    assert served.ask("POST", "/v1/identify", scan)[1]["subject"] == "ann"


# ── workers, gallery, stop ───────────────────────────────────────────────────────────────


@pytest.fixture
def fresh(tmp_path):
    service = Served(tmp_path, {"workers": 1, "scan_s": 5.0, "requests_per_s": 0.01, "burst": 9.0})
    yield service.start()
    service.stop(signal.SIGKILL)


def workers_of(process: int) -> list[int]:
    children = Path(f"/proc/{process}/task/{process}/children")
    return [int(text) for text in children.read_text().split()]


@pytest.mark.slow
def test_a_worker_that_dies_or_hangs_is_replaced_and_the_service_stops_cleanly(fresh, scan_of):
    (worker,) = workers_of(fresh.process.pid)
    os.kill(worker, signal.SIGSTOP)
    assert fresh.ask("POST", "/v1/identify", scan_of(1))[1]["reason"] == "scan-too-slow"
    assert fresh.ask("POST", "/v1/identify", scan_of(1))[1]["reason"] == "nobody enrolled"
    (worker,) = workers_of(fresh.process.pid)
    os.kill(worker, signal.SIGKILL)
    assert fresh.ask("POST", "/v1/identify", scan_of(1))[1]["reason"] == "scan-refused"
    assert fresh.ask("POST", "/v1/people", scan_of(1), subject="ann")[0] == 201

    (fresh.folder / "gallery.db").chmod(0o444)
    if os.geteuid() != 0:  # root may write all the same
        status, problem = fresh.ask("POST", "/v1/people", scan_of(2), subject="bob")
        assert (status, problem["reason"]) == (503, "gallery-unavailable")
        assert "readonly" in problem["detail"]
    (fresh.folder / "gallery.db").chmod(0o644)

    raw_file = sqlite3.connect(fresh.folder / "gallery.db")
    with raw_file:
        raw_file.execute("UPDATE people SET name = 'eve'")
    raw_file.close()
    status, problem = fresh.ask("POST", "/v1/identify", scan_of(1))
    assert (status, problem["reason"]) == (503, "gallery-unavailable")
    assert problem["detail"] == "damaged (a record was altered); restore a backup"
    assert fresh.ask("GET", "/readyz", key=None)[1]["reason"] == "gallery-unavailable"

    while fresh.ask("GET", "/v1/status")[0] != 429:  # nine requests, then one in 100 s
        pass
    status, headers, problem = fresh.ask_headers("GET", "/v1/status")
    assert (status, problem["reason"]) == (429, "too-many-requests")
    assert 1 <= int(headers["retry-after"]) <= 100

    (worker,) = workers_of(fresh.process.pid)
    assert fresh.stop() == 0
    assert not Path(f"/proc/{worker}").exists()
    log = fresh.log.read_text()
    assert fresh.key.split(".")[2] not in log
    assert "ann" not in log
    assert "Traceback" not in log


def test_another_model_s_gallery_is_not_served(tmp_path):
    from rangeface.app.models import load_model
    from rangeface.app.server import create_app
    from rangeface.gallery import MemoryGallery
    from rangeface.types import Template

    gallery = MemoryGallery()
    gallery.enroll("ann", Template(([[1.0]],), "f" * 64))
    with pytest.raises(GalleryError, match="enrol"):
        create_app(load_model(None), gallery, Settings(keys=tmp_path / "k"))


def test_a_model_that_is_not_calibrated_is_not_served(tmp_path):
    from dataclasses import replace

    import numpy as np

    from rangeface.app.models import load_model
    from rangeface.app.server import create_app
    from rangeface.gallery import MemoryGallery

    model = replace(load_model(None), nonmated=np.empty(0, np.float32))
    with pytest.raises(ParameterError, match="not calibrated"):
        create_app(model, MemoryGallery(), Settings(keys=tmp_path / "k"))
