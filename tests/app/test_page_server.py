"""The page's routes and commands over real sockets: who is let in, and what is answered."""

from __future__ import annotations

import json
import socket
import sys
import threading
import time
import urllib.error
import urllib.request
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import pytest
import uvicorn
from tests.conftest import sr3000_face
from websockets.exceptions import ConnectionClosed
from websockets.sync import client

from rangeface.app import cli
from rangeface.app.models import load_model
from rangeface.app.server.keys import Scope
from rangeface.app.server.live import page_app
from rangeface.app.server.sessions import Sessions
from rangeface.app.viewing.enrolment import Enrolment
from rangeface.app.viewing.stage import Stage
from rangeface.errors import GalleryError, SourceError
from rangeface.gallery import MemoryGallery
from rangeface.sources import Frame, Player
from rangeface.sources._protocol import Closing

PATIENCE_S = 60.0


class Still(Closing):
    """Somebody who stands still, forty frames a second; "broken" breaks after five frames."""

    rate_hz = 40.0

    def __init__(self, name: str) -> None:
        self.name = name
        self._images = [sr3000_face(3, noise=k)[0] for k in range(4)]
        self._closed = False

    def close(self) -> None:
        self._closed = True

    def __iter__(self):
        number = 0
        while not self._closed:
            if self.name == "broken" and number == 5:
                raise SourceError("broken: unplugged")
            yield Frame(self._images[number % 4], number / self.rate_hz, number)
            number += 1


def opened(address: str) -> Player:
    if address == "absent":
        raise SourceError("absent: no such camera")
    return Player(Still(address))


class Page:
    """A page without a browser."""

    def __init__(self, socket: client.ClientConnection) -> None:
        self._socket = socket
        self.state: dict = {}
        self.frames: list[dict] = []
        self.missed = 0
        self._number = 0

    def hear(self, *, seen: bool = True) -> dict | None:
        """One message; a reply is returned."""
        message = self._socket.recv(timeout=PATIENCE_S)
        if isinstance(message, str):
            said = json.loads(message)
            self.state = said.get("state", self.state)
            return said if "reply" in said else None
        self.missed = int.from_bytes(message[:4], "little")
        length = int.from_bytes(message[4:8], "little")
        self.frames.append(json.loads(message[8 : 8 + length]))
        if seen:
            self._socket.send(json.dumps({"seen": self.frames[-1]["frame"]}))
        return None

    def hear_until(self, true) -> None:
        end = time.monotonic() + PATIENCE_S
        while not true():
            assert time.monotonic() < end, self.state
            self.hear()

    def ask(self, **command) -> str | None:
        self._number += 1
        self._socket.send(json.dumps({"id": self._number, **command}))
        while (reply := self.hear()) is None:
            pass
        assert reply["reply"] == self._number
        return reply["error"]

    def say(self, text: str) -> None:
        self._socket.send(text)


@dataclass(frozen=True)
class Site:
    """The server in a thread, and ways to get in."""

    stage: Stage
    gallery: MemoryGallery
    place: str
    sessions: Sessions
    recordings: Path

    def sign_in(self, token: str, origin: str | None = None) -> str:
        request = urllib.request.Request(
            f"http://{self.place}/live/session", method="POST",
            headers={"Authorization": f"Bearer {token}",
                     "Origin": origin or f"http://{self.place}"},
        )  # fmt: skip
        with urllib.request.urlopen(request) as answer:
            cookie = answer.headers["Set-Cookie"]
        assert "HttpOnly" in cookie
        assert "SameSite=strict" in cookie
        return cookie.partition(";")[0]

    @contextmanager
    def page(self, scopes=tuple(Scope), *, cookie: str | None = None, origin: str | None = None):
        known = cookie or self.sign_in(self.sessions.invite(scopes))
        with client.connect(
            f"ws://{self.place}/live/socket", origin=origin or f"http://{self.place}",
            additional_headers={"Cookie": known}, max_size=None,
        ) as socket:  # fmt: skip
            yield Page(socket)


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    recognizer, gallery, sessions = load_model(None), MemoryGallery(), Sessions()
    gallery.enroll("ann", recognizer.template(sr3000_face(4)[0]))
    recordings = tmp_path_factory.mktemp("recordings")
    stage = Stage(
        recognizer, gallery, opener=opened, recordings=recordings,
        sources={name: name.title() for name in ("still", "broken", "absent")},
    )  # fmt: skip
    stage.choose("still")
    listening = socket.create_server(("127.0.0.1", 0))
    place = f"127.0.0.1:{listening.getsockname()[1]}"
    app = page_app(stage, sessions, hosts=("127.0.0.1",))
    server = uvicorn.Server(uvicorn.Config(app, ws="websockets-sansio", log_config=None))
    thread = threading.Thread(target=server.run, kwargs={"sockets": [listening]})
    thread.start()
    yield Site(stage, gallery, place, sessions, recordings)
    server.should_exit = True
    thread.join(PATIENCE_S)
    listening.close()


@pytest.fixture(autouse=True)
def still(site):
    site.stage.choose("still")


def refused(site: Site, token: str, **changes) -> int:
    with pytest.raises(urllib.error.HTTPError) as error:
        site.sign_in(token, **changes)
    error.value.close()
    return error.value.code


def test_an_invitation_is_good_for_once(site):
    token = site.sessions.invite()
    assert site.sign_in(token).startswith("rangeface-")
    assert refused(site, token) == 401
    assert refused(site, "guess") == 401


def test_another_sites_page_gets_no_session_and_no_socket(site):
    assert refused(site, site.sessions.invite(), origin="http://evil.example") == 403
    cookie = site.sign_in(site.sessions.invite())
    for told in ({"cookie": cookie, "origin": "http://evil.example"}, {"cookie": "rangeface-1=no"}):
        with site.page(**told) as stranger, pytest.raises(ConnectionClosed) as closed:
            stranger.hear()
        assert closed.value.rcvd.code == 4401


def test_frames_come_with_what_was_seen_in_them(site):
    with site.page() as page:
        page.hear_until(lambda: page.frames and page.frames[-1]["faces"])
        head = page.frames[-1]
        (face,) = head["faces"]
        left, top, width, height = face["box"]
        assert left <= 92 <= left + width
        assert top <= 70 <= top + height
        assert {"denoise", "follow", "look"} <= set(head["times_ms"])
        assert head["followed"] == face["track"]
        assert page.ask(do="follow", track=10**6) is None
        page.hear_until(
            lambda: page.frames[-1]["followed"] == face["track"]
        )  # nobody else is there
        page.hear_until(lambda: len(page.frames[-1]["planes"]) == 2)
        assert [p["name"] for p in page.frames[-1]["planes"]] == ["depth", "surface"]
        assert [s["name"] for s in page.state["sources"]] == ["still", "broken", "absent"]


def test_a_page_that_shows_nothing_is_sent_two_frames_and_told_what_it_missed(site):
    with site.page() as page:
        while len(page.frames) < 2:
            page.hear(seen=False)
        numbers = [frame["frame"] for frame in page.frames]
        time.sleep(1.0)
        page.say(json.dumps({"seen": numbers[-1]}))
        page.hear_until(lambda: len(page.frames) == 3)
        assert page.missed > 0
        assert page.frames[-1]["frame"] >= numbers[0] + page.missed + 1


@pytest.mark.parametrize(
    "text", ["{", "7", "{}", '{"id": 1, "do": "explode"}', '{"id": "1", "do": "play"}',
             '{"id": 1, "do": "delete", "subject": 5}', '{"seen": true}', "9" * 5000]
)  # fmt: skip
def test_who_talks_nonsense_is_hung_up_on(site, text):
    with site.page() as page:
        page.say(text)
        with pytest.raises(ConnectionClosed) as closed:
            page.hear_until(lambda: False)
        assert closed.value.rcvd.code == 4400


def test_a_command_needs_its_scope(site):
    with site.page((Scope.IDENTIFY,)) as page:
        assert "scope delete" in page.ask(do="delete", subject="ann")
        assert "scope admin" in page.ask(do="pause")
        assert "scope enroll" in page.ask(do="enrol", subject="eva", track=1)
    with site.page((Scope.LIST,)) as page, pytest.raises(ConnectionClosed):
        page.hear()
    assert site.gallery.subjects() == ("ann",)


def test_pause_step_and_play(site):
    with site.page() as page:
        page.hear_until(lambda: page.frames)
        assert page.ask(do="pause") is None
        page.hear_until(lambda: not page.state["playing"])
        time.sleep(0.5)
        assert page.ask(do="pause") is None  # all that was on its way has come by now
        before = page.frames[-1]["frame"]
        assert page.ask(do="step") is None
        page.hear_until(lambda: page.frames[-1]["frame"] > before)
        assert page.frames[-1]["frame"] == before + 1
        assert page.ask(do="play") is None
        page.hear_until(lambda: page.frames[-1]["frame"] > before + 3)


def test_a_source_that_breaks_is_told_and_can_be_chosen_again(site):
    with site.page() as page:
        assert page.ask(do="source", name="broken") is None
        page.hear_until(lambda: page.state.get("problem"))
        assert page.state["problem"] == "broken: unplugged"
        assert not page.state["playing"]
        assert page.ask(do="source", name="absent") == "absent: no such camera"
        assert "not offered" in page.ask(do="source", name="mcap:/etc/passwd")
        assert page.ask(do="source", name="still") is None
        page.hear_until(lambda: page.state["playing"] and not page.state["problem"])


def test_denoising_is_chosen_and_an_unknown_method_refused(site):
    with site.page() as page:
        assert "unknown method" in page.ask(do="denoise", name="magic")
        assert page.ask(do="denoise", name="median") is None
        page.hear_until(lambda: page.state["denoiser"] == "median")
        assert page.ask(do="denoise", name="none") is None


def test_recordings_hold_the_frames(site):
    from rangeface.sources import Recording

    with site.page() as page:
        assert page.ask(do="record", on=True) is None
        page.hear_until(lambda: page.state["recording"])
        file = page.state["recording"]["file"]
        seen = len(page.frames)
        page.hear_until(lambda: len(page.frames) > seen + 5)
        assert page.ask(do="record", on=False) is None
        page.hear_until(lambda: page.state["recording"] is None)
    (path,) = site.recordings.glob(file)
    assert sum(1 for _ in Recording(path)) >= 5


def test_enrolment_collects_saves_and_deletes(site):
    with site.page() as page:
        page.hear_until(lambda: page.frames and page.frames[-1]["faces"])
        track = page.frames[-1]["faces"][0]["track"]
        assert "enrolled already" in page.ask(do="enrol", subject="ann", track=track)
        assert "printable" in page.ask(do="enrol", subject="\x07", track=track)
        assert "Not enough" in page.ask(do="save")
        assert page.ask(do="enrol", subject="eva", track=track) is None
        page.hear_until(lambda: page.state["enrolment"] and page.state["enrolment"]["sufficient"])
        assert page.ask(do="save") is None
        page.hear_until(lambda: page.state["gallery"][-1]["subject"] == "eva")
        page.hear_until(lambda: page.frames[-1]["faces"][0]["subject"] == "eva")
        assert page.ask(do="delete", subject="eva") is None
        assert "not enrolled" in page.ask(do="delete", subject="eva")
        page.hear_until(lambda: len(page.state["gallery"]) == 1)
        page.hear_until(lambda: page.frames[-1]["faces"][0]["subject"] is None)


def test_a_gallery_that_cannot_be_written_is_told_and_the_view_goes_on(site, monkeypatch):
    def full(*_):
        raise GalleryError("disk full")

    monkeypatch.setattr(Enrolment, "complete", property(lambda enrolment: enrolment.sufficient))
    monkeypatch.setattr(site.gallery, "enroll", full)
    with site.page() as page:
        page.hear_until(lambda: page.frames and page.frames[-1]["faces"])
        track = page.frames[-1]["faces"][0]["track"]
        assert page.ask(do="enrol", subject="eva", track=track) is None
        page.hear_until(lambda: page.state["problem"])
        assert page.state["problem"] == "disk full"
        seen = len(page.frames)
        page.hear_until(lambda: len(page.frames) > seen)
        assert page.ask(do="denoise", name="none") is None
        page.hear_until(lambda: page.state["problem"] is None)


def test_an_enrolment_can_be_given_up(site):
    with site.page() as page:
        assert page.ask(do="enrol", subject="eva", track=10**6) is None
        page.hear_until(lambda: page.state["enrolment"])
        page.hear_until(lambda: page.state["enrolment"]["hint"] == "Come back into view")
        assert page.ask(do="cancel") is None
        page.hear_until(lambda: page.state["enrolment"] is None)


def test_files_are_these_and_no_others(site):
    for path, kind in (("", "text/html"), ("assets/page.js", "text/javascript")):
        with urllib.request.urlopen(f"http://{site.place}/{path}") as answer:
            assert answer.headers["Content-Type"].startswith(kind)
            assert "default-src 'none'" in answer.headers["Content-Security-Policy"]
    for path in ("assets/..%2f..%2fcli.py", "assets/SOURCE", "page/index.html"):
        with pytest.raises(urllib.error.HTTPError) as error:
            urllib.request.urlopen(f"http://{site.place}/{path}")
        error.value.close()
        assert error.value.code == 404


@pytest.mark.parametrize(
    ("arguments", "answer"),
    [
        (["serve"], "--gallery FILE is needed (or --demo)"),
        (["live", "nonsense"], "is no address"),
        (["live", "mcap:absent.mcap"], "file not found"),
    ],
)
def test_a_wrong_start_is_one_line(arguments, answer, monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["rangeface", *arguments])
    with pytest.raises(SystemExit) as stop:
        cli.main()
    assert stop.value.code == 2
    error = capsys.readouterr().err
    assert answer in error
    assert error.count("\n") == 1
