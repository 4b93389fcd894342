"""A door and an enrolment desk: two clients of one service, each with a key for its own work.

The desk takes a person's consent and several captures, enrols those that are fit, and checks at
once that the person is known. The door opens for who is *accepted*, asks to look again on *cannot
tell*, and stays shut for the unknown; after five refusals in a row the service makes it wait.

Here both talk to a service in the same process, with people who do not exist. In earnest the
service is ``rangeface serve --gallery door.db``, keys are made with ``rangeface key add``, and
``scans`` comes from a camera's folder.
"""

import socket
import tempfile
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from datetime import date, timedelta
from pathlib import Path

import numpy as np
import uvicorn

from rangeface import sensors, simulate
from rangeface.app.models import load_model
from rangeface.app.server import Settings, create_app
from rangeface.app.server.keys import KeyRing, Scope
from rangeface.client import Client, ServiceError
from rangeface.gallery import MemoryGallery
from rangeface.io import write_scan
from rangeface.types import Verdict

ANSWERS = {
    Verdict.ACCEPTED: "opens",
    Verdict.UNKNOWN: "stays shut",
    Verdict.CANNOT_TELL: "asks to look again",
}


def enrol(desk: Client, name: str, scans: Sequence[Path], consent: str) -> bool:
    """Enrol a person from their captures; whether they are known afterwards."""
    *first, last = scans
    for scan in first:
        try:
            desk.enroll(name, scan, consent=consent, expires=date.today() + timedelta(days=365))
        except ServiceError as refused:
            print(f"desk: please look at the camera again ({refused.why or refused})")
    try:
        known = desk.verify(name, last).verdict is Verdict.ACCEPTED
    except ServiceError as refused:
        known = False
        print(f"desk: {refused}")
    print(f"desk: {name} is {'known' if known else 'not known'} now")
    return known


def pass_by(door: Client, scan: Path) -> str:
    """What the door does when somebody stands before it."""
    try:
        decision = door.identify(scan)
    except ServiceError as refused:
        if refused.retry_s is None:
            return f"stays shut ({refused.reason})"
        return f"waits {refused.retry_s:.0f} s ({refused.reason})"
    return ANSWERS[decision.verdict] + (f" for {decision.subject}" if decision.subject else "")


def main() -> list[str]:
    """Enrol two people, let them and strangers stand before the door; print what it does."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        with service(folder) as (url, keys):
            desk_key = keys.add("desk", [Scope.ENROLL, Scope.VERIFY, Scope.DELETE])
            door_key = keys.add("door", [Scope.IDENTIFY])
            with Client(url, key=desk_key) as desk, Client(url, key=door_key) as door:
                for person, who in ((1, "ann"), (2, "bob")):
                    enrol(desk, who, [capture(folder, person, k) for k in range(3)], f"C-{person}")
                seen = [pass_by(door, capture(folder, person, 9)) for person in (1, 2)]
                seen += [pass_by(door, capture(folder, stranger, 9)) for stranger in range(20, 26)]
                desk.delete("bob")
    print(*(f"door: {line}" for line in seen), sep="\n")
    return seen


@contextmanager
def service(folder: Path) -> Iterator[tuple[str, KeyRing]]:
    """A service in a thread of this process: its address and its keys."""
    settings = Settings(keys=folder / "example.keys", workers=1)
    app = create_app(load_model(None), MemoryGallery(), settings)
    with socket.create_server(("127.0.0.1", 0)) as listener:
        server = uvicorn.Server(uvicorn.Config(app, log_config=None, access_log=False))
        thread = threading.Thread(target=server.run, args=([listener],))
        thread.start()
        try:
            while not app.state.service.workers.ready:
                time.sleep(0.1)
            yield f"http://127.0.0.1:{listener.getsockname()[1]}", app.state.service.keys
        finally:
            server.should_exit = True
            thread.join()


def capture(folder: Path, person: int, noise: int) -> Path:
    """A scan of somebody who does not exist, 40 cm before a time-of-flight camera."""
    pose = simulate.pose(nose_tip_mm=(4.0, -6.0, 400.0))
    clean = simulate.render(simulate.head(person), sensors.preset("sr3000").camera, pose).image
    path = folder / f"{person}-{noise}.npz"
    write_scan(path, simulate.add_noise(clean, 1.0, rng=np.random.default_rng(noise)))
    return path


if __name__ == "__main__":
    main()
