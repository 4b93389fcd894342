"""What the service answers to those who may ask."""

from __future__ import annotations

import http.client
from contextlib import closing

import pytest

from rangeface.client import Client, ServiceError
from rangeface.types import Verdict


def test_an_enrolled_person_is_identified(served, scan_of):
    status, answer = served.ask("POST", "/v1/identify", scan_of(1, 5))
    assert status == 200
    assert (answer["verdict"], answer["subject"], answer["reason"]) == ("accepted", "ann", None)
    assert answer["score"] >= answer["threshold"]
    assert answer["ranking"][0]["subject"] == "ann"


def test_a_stranger_is_unknown_and_a_wall_is_no_face(served, scan_of):
    status, answer = served.ask("POST", "/v1/identify", scan_of(7))
    assert (status, answer["verdict"], answer["subject"]) == (200, "unknown", None)
    wall = b"".join(b"v %d %d -700\n" % (x, y) for x in range(30) for y in range(30))
    status, answer = served.ask("POST", "/v1/identify", wall)
    assert (status, answer["verdict"], answer["reason"]) == (200, "cannot tell", "no face found")
    served.ask("DELETE", "/v1/attempts")


def test_scores_are_for_those_who_have_the_scope(served, scan_of):
    key = served.new_key("identify")
    _, answer = served.ask("POST", "/v1/identify", scan_of(1, 5), key=key)
    assert answer["subject"] == "ann"
    assert answer["score"] is answer["threshold"] is answer["ranking"] is None


def test_a_claim_is_checked(served, scan_of):
    assert served.ask("POST", "/v1/verify", scan_of(2, 3), subject="bob")[1]["subject"] == "bob"
    assert served.ask("POST", "/v1/verify", scan_of(1, 3), subject="bob")[1]["verdict"] == "unknown"
    status, problem = served.ask("POST", "/v1/verify", scan_of(1, 3), subject="nobody")
    assert (status, problem["reason"]) == (404, "not-enrolled")
    served.ask("DELETE", "/v1/attempts")


def test_who_is_enrolled_is_listed_and_who_is_deleted_is_not_known(served, scan_of):
    name = "Çelik, Ömer / 7 & co?"
    status, answer = served.ask(
        "POST", "/v1/people", scan_of(3), subject=name, consent="C-1", expires="2999-12-31"
    )
    assert (status, answer["people"]) == (201, 3)
    _, page = served.ask("GET", "/v1/people", offset=2, limit=1)
    assert page == {
        "total": 3,
        "people": [{"subject": name, "consent": "C-1", "expires": "2999-12-31"}],
    }
    assert served.ask("POST", "/v1/identify", scan_of(3, 1))[1]["subject"] == name
    _, answer = served.ask("DELETE", "/v1/people", subject=name)
    assert answer == {"subject": name, "templates": 1}
    assert served.ask("POST", "/v1/identify", scan_of(3, 1))[1]["subject"] is None
    assert served.ask("DELETE", "/v1/people", subject=name)[0] == 404
    _, lines = served.ask("GET", "/v1/audit")
    assert [line["action"] for line in lines[-2:]] == ["enrolled", "deleted"]
    assert set(lines[-1]) == {"at", "action", "person"}
    served.ask("DELETE", "/v1/attempts")


def test_an_expired_consent_is_not_searched(served, scan_of):
    served.ask("POST", "/v1/people", scan_of(4), subject="cy", consent="C", expires="2020-01-01")
    try:
        assert served.ask("POST", "/v1/identify", scan_of(4, 1))[1]["subject"] is None
        status, problem = served.ask("POST", "/v1/verify", scan_of(4, 1), subject="cy")
        assert (status, problem["reason"]) == (404, "not-enrolled")
    finally:
        served.ask("DELETE", "/v1/people", subject="cy")
        served.ask("DELETE", "/v1/attempts")


def test_a_picture_needs_a_camera_which_the_query_can_give(served, scan_of):
    picture = scan_of(1, 9, ending="png")
    status, problem = served.ask("POST", "/v1/identify", picture)
    assert (status, problem["why"]) == (422, "bad camera")
    status, problem = served.ask("POST", "/v1/identify", picture, fx=200)
    assert (status, problem["reason"]) == (422, "bad-parameter")
    status, answer = served.ask(
        "POST", "/v1/identify", picture,
        fx=200, fy=200, cx=87.5, cy=71.5, width=176, height=144, unit="mm",
    )  # fmt: skip
    assert status == 200
    assert answer["verdict"] == "cannot tell"  # its step is no millimetre


def test_a_scan_that_is_none_is_refused_with_its_fault(served):
    status, problem = served.ask("POST", "/v1/identify", b"garbage")
    assert status == 422
    assert problem["type"] == "urn:rangeface:problem:scan-refused"
    assert (problem["reason"], problem["why"]) == ("scan-refused", "unknown format")
    assert served.ask("POST", "/v1/identify", b"")[1]["reason"] == "scan-refused"


def test_no_face_is_not_enrolled(served):
    wall = b"".join(b"v %d %d -700\n" % (x, y) for x in range(30) for y in range(30))
    status, problem = served.ask("POST", "/v1/people", wall, subject="wall")
    assert (status, problem["reason"], problem["why"]) == (422, "no-face", "no face found")


@pytest.mark.parametrize(
    ("method", "path", "query", "status", "reason"),
    [
        ("POST", "/v1/people", {"subject": ""}, 422, "bad-parameter"),
        ("POST", "/v1/people", {"subject": "a\nb"}, 422, "bad-parameter"),
        ("POST", "/v1/people", {"subject": "x" * 201}, 422, "bad-parameter"),
        ("POST", "/v1/people", {"subject": "x", "expires": "2030-01-01"}, 422, "bad-parameter"),
        ("POST", "/v1/people", {"subject": "x", "expires": "soon"}, 422, "bad-parameter"),
        ("POST", "/v1/identify", {"unit": "league"}, 422, "bad-parameter"),
        ("GET", "/v1/people", {"limit": 0}, 422, "bad-parameter"),
        ("GET", "/v1/nothing", {}, 404, "not-found"),
        ("PUT", "/v1/people", {}, 405, "method-not-allowed"),
    ],
)
def test_what_cannot_be_asked(served, method, path, query, status, reason):
    found, problem = served.ask(method, path, b"x", **query)
    assert (found, problem["reason"]) == (status, reason)


def test_it_is_alive_ready_and_counts(served, scan_of):
    served.ask("POST", "/v1/identify", scan_of(1, 5))
    assert served.ask("GET", "/healthz", key=None) == (200, {"status": "ok"})
    assert served.ask("GET", "/readyz", key=None) == (200, {"status": "ok"})
    _, status = served.ask("GET", "/v1/status")
    assert status["people"] == 2
    assert status["workers"] == 1
    _, text = served.ask("GET", "/metrics")
    assert 'rangeface_decisions_total{kind="identify",verdict="accepted"}' in text
    assert "rangeface_people 2" in text
    assert "bob" not in text


def test_the_openapi_document_describes_every_route(served):
    _, document = served.ask("GET", "/openapi.json")
    assert set(document["paths"]) >= {
        "/v1/identify", "/v1/verify", "/v1/people", "/v1/audit", "/v1/status",
        "/v1/attempts", "/healthz", "/readyz", "/metrics",
    }  # fmt: skip
    assert "Problem" in document["components"]["schemas"]


def test_an_address_under_another_name_is_refused(served):
    """A page of another site cannot reach the service through a name that it controls."""
    with closing(served.connect()) as connection:
        connection.request("GET", "/healthz", headers={"Host": "evil.example"})
        assert connection.getresponse().status == 421


def test_the_client_does_all_of_it(served, scan_of, tmp_path):
    (tmp_path / "key").write_text(served.key + "\n")
    (tmp_path / "probe.npz").write_bytes(scan_of(1, 6))
    with Client(f"http://127.0.0.1:{served.port}", key_file=tmp_path / "key") as client:
        assert client.identify(tmp_path / "probe.npz").subject == "ann"
        assert client.verify("ann", scan_of(1, 7)).verdict is Verdict.ACCEPTED
        assert client.enroll("dee", scan_of(5), consent="C-2") == 3
        assert [p.subject for p in client.people()] == ["ann", "bob", "dee"]
        assert client.people()[2].consent == "C-2"
        assert client.delete("dee") == 1
        assert client.status()["people"] == 2
        with pytest.raises(ServiceError, match="unknown format") as caught:
            client.identify(b"garbage")
        assert (caught.value.status, caught.value.reason) == (422, "scan-refused")


def test_what_the_client_cannot_do(tmp_path):
    from rangeface.errors import ParameterError

    with pytest.raises(ParameterError, match="url"):
        Client("ftp://somewhere", key="k")
    with pytest.raises(ParameterError, match="give one"):
        Client("http://127.0.0.1:1")
    with Client("http://127.0.0.1:1", key="k") as client:
        with pytest.raises(ServiceError, match="unreachable") as caught:
            client.status()
        assert isinstance(caught.value.__cause__, OSError | http.client.HTTPException)
