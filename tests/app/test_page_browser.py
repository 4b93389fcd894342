"""The page as people use it: headless Chromium, the real server, the synthetic camera.

With RANGEFACE_SCREENSHOTS=FOLDER the pictures of the README are written there.
"""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
import sys
import threading
import urllib.error
import urllib.request
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

CHROMIUM = shutil.which("chromium")
playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(CHROMIUM is None, reason="chromium is not installed"),
]

PATIENCE_MS = 90_000  # for what takes two seconds where nothing else runs
FRIENDS = re.compile("^(Ada|Bruno|Chiara|Dana|Emil|Farah)$")
FLAGS = ["--no-sandbox", "--disable-gpu", "--disable-background-networking"]
MAIN = "from rangeface.app.cli import main; main()"


@dataclass
class Server:
    """`rangeface serve --demo` in a process of its own."""

    process: subprocess.Popen[str]
    url: str = ""
    lines: list[str] = field(default_factory=list)
    reader: threading.Thread | None = None

    @property
    def place(self) -> str:
        return self.url.partition("#")[0]


def started(*arguments: str, folder: Path) -> Server:
    process = subprocess.Popen(
        [sys.executable, "-u", "-c", MAIN, *arguments], cwd=folder, text=True,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
    )  # fmt: skip
    server = Server(process)
    ready = threading.Event()

    def read() -> None:
        for line in process.stdout:
            server.lines.append(line)
            if found := re.search(r"http://\S+", line):
                server.url = found.group(0)
                ready.set()
        ready.set()

    server.reader = threading.Thread(target=read, daemon=True)
    server.reader.start()
    assert ready.wait(180), "the server did not start in time"
    assert server.url, "".join(server.lines)
    return server


def stopped(server: Server) -> None:
    server.process.send_signal(signal.SIGTERM)
    status = server.process.wait(20)
    server.reader.join(20)
    server.process.stdout.close()
    assert status in (0, -signal.SIGTERM), "".join(server.lines)
    assert "Traceback" not in "".join(server.lines)


@pytest.fixture
def server(tmp_path) -> Iterator[Server]:
    running = started("serve", "--demo", "--port", "0", folder=tmp_path)
    yield running
    stopped(running)


@pytest.fixture(scope="module")
def chromium() -> Iterator[Any]:
    with playwright.sync_playwright() as p:
        browser = p.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        yield browser
        browser.close()


@pytest.fixture
def complaints() -> list[str]:
    return []


@pytest.fixture
def new_page(chromium, server, complaints):
    """Opens the page at a width, in light or dark; collects errors and foreign requests."""
    contexts: list[Any] = []

    def open_page(width: int = 1280, height: int = 800, *, dark: bool = False, before: str = ""):
        known = contexts[0].storage_state() if contexts else None
        context = chromium.new_context(
            viewport={"width": width, "height": height}, storage_state=known,
            color_scheme="dark" if dark else "light",
        )  # fmt: skip
        contexts.append(context)
        page = context.new_page()
        page.set_default_timeout(PATIENCE_MS)
        if before:
            page.add_init_script(before)
        page.on("pageerror", lambda error: complaints.append(str(error)))
        page.on("console", lambda said: said.type == "error" and complaints.append(said.text))
        page.on("request", lambda asked: foreign(asked.url))
        page.goto(server.url if known is None else server.place)
        return page

    def foreign(url: str) -> None:
        if not url.startswith(server.place):
            complaints.append(f"asked {url}")

    yield open_page
    for context in contexts:
        context.close()


def expect(locator):
    return playwright.expect(locator)


def shows(page, verdict: str, who: re.Pattern[str] | str) -> None:
    """The large card says so."""
    expect(page.locator("#card")).to_have_class(f"card {verdict}", timeout=PATIENCE_MS)
    expect(page.locator("#who")).to_have_text(who, timeout=PATIENCE_MS)


def frame(page) -> int:
    return int(page.locator("body").get_attribute("data-frame"))


def picture(page, name: str, *, faces: int = 1) -> None:
    """For the README: when so many faces have their name."""
    if folder := os.environ.get("RANGEFACE_SCREENSHOTS"):
        expect(page.locator(".box.accepted")).to_have_count(faces, timeout=PATIENCE_MS)
        page.wait_for_timeout(2500)
        page.screenshot(path=Path(folder) / f"{name}.png", full_page=True)


def test_friends_are_named_strangers_refused_enrolled_known_and_forgotten(new_page, complaints):
    page = new_page()
    shows(page, "accepted", FRIENDS)
    expect(page.locator(".box.accepted .tag").first).to_contain_text(page.inner_text("#who"))
    expect(page.locator("#surface-figure[data-empty]")).to_have_count(0)
    picture(page, "live-1280", faces=2)

    page.select_option("#source", label="A stranger")
    shows(page, "unknown", "Unknown")
    expect(page.locator("#people li")).to_have_count(6)

    page.click("#enrol")
    page.fill("#enrol-name", "Gero")
    page.click("#enrol-form button[type=submit]")
    expect(page.locator("#enrolment")).to_be_visible()
    expect(page.locator("#hint")).not_to_be_empty()
    expect(page.locator("#people li", has_text="Gero")).to_have_count(1, timeout=PATIENCE_MS)
    shows(page, "accepted", "Gero")
    expect(page.locator("#spoken")).to_contain_text("Gero recognised", timeout=PATIENCE_MS)

    page.click("button[aria-label='Delete Gero']")
    page.click("#confirm button[value=delete]")
    expect(page.locator("#people li", has_text="Gero")).to_have_count(0)
    shows(page, "unknown", "Unknown")
    assert complaints == []


def test_a_phone_shows_the_same_without_scrolling_sideways(new_page, complaints):
    page = new_page(390, 844, dark=True)
    shows(page, "accepted", FRIENDS)
    assert page.evaluate("document.documentElement.scrollWidth") == 390
    for control in ("#play", "#record", "#source", "#denoiser", "#enrol", "#theme", "#surface"):
        box = page.locator(control).bounding_box()
        assert box is not None, control
        assert box["height"] >= 36, f"{control} is too small for a finger"
    assert page.locator("#decision").bounding_box()["y"] < 844 / 2, "who it is comes first"
    picture(page, "live-390")
    assert complaints == []


def test_the_keyboard_suffices(new_page):
    page = new_page()
    expect(page.locator("#status-label")).to_have_text("Live", timeout=PATIENCE_MS)
    page.wait_for_selector("body[data-frame]")
    page.keyboard.press("Space")
    expect(page.locator("#status-label")).to_have_text("Paused", timeout=PATIENCE_MS)
    page.wait_for_timeout(1500)  # what was on its way has arrived
    before = frame(page)
    page.keyboard.press(".")
    expect(page.locator("body")).not_to_have_attribute("data-frame", str(before))
    page.wait_for_timeout(500)
    assert frame(page) == before + 1
    page.keyboard.press("t")
    expect(page.locator("html")).to_have_attribute("data-theme", "dark")
    page.keyboard.press("?")
    expect(page.locator("#help")).to_be_visible()
    page.keyboard.press("Escape")
    expect(page.locator("#help")).to_be_hidden()
    page.wait_for_timeout(500)  # the focus comes back from the dialog
    page.keyboard.press("Space")
    expect(page.locator("#status-label")).to_have_text("Live", timeout=PATIENCE_MS)
    page.evaluate("document.activeElement.blur()")
    order = []
    for _ in range(16):
        page.keyboard.press("Tab")
        order.append(page.evaluate("document.activeElement.id || document.activeElement.className"))
    wanted = ["help-open", "theme", "play", "record", "source", "denoiser", "surface"]
    places = [order.index(name) for name in wanted]
    assert places == sorted(places), order


def test_a_slow_page_shows_what_it_was_not_sent_and_stays_at_the_newest(new_page):
    slow = "window.requestAnimationFrame = (draw) => setTimeout(() => draw(performance.now()), 600)"
    page = new_page(before=slow)
    page.wait_for_selector("body[data-frame]")
    expect(page.locator("#dropped-page")).to_have_text(re.compile("^[1-9]"), timeout=PATIENCE_MS)
    first, dropped = frame(page), int(page.inner_text("#dropped-page"))
    page.wait_for_timeout(4000)
    assert frame(page) - first > int(page.inner_text("#dropped-page")) - dropped > 0


def test_denoising_and_recording(new_page, tmp_path):
    page = new_page()
    page.wait_for_selector("body[data-frame]")
    page.select_option("#denoiser", "median")
    page.click("#record")
    expect(page.locator("#recording")).to_contain_text(".mcap")
    shows(page, "accepted", FRIENDS)
    page.click("#record")
    expect(page.locator("#recording")).to_be_empty()
    from rangeface.sources import Recording

    (file,) = tmp_path.glob("*.mcap")
    assert sum(1 for _ in Recording(file)) > 5


def test_the_address_opens_one_browser_only(server, chromium):
    first, second = (chromium.new_context() for _ in range(2))
    page = first.new_page()
    page.goto(server.url)
    page.wait_for_selector("body[data-frame]", timeout=PATIENCE_MS)
    assert "#" not in page.url, "the token stays in the address"
    page.reload()
    page.wait_for_selector("body[data-frame]", timeout=PATIENCE_MS)
    other = second.new_page()
    other.goto(server.url)
    expect(other.locator("#sign-in")).to_be_visible(timeout=PATIENCE_MS)
    assert other.locator("body[data-frame]").count() == 0
    first.close()
    second.close()


def test_the_page_is_fenced_in(server):
    with urllib.request.urlopen(server.place) as answer:
        policy = answer.headers["Content-Security-Policy"]
        assert "default-src 'none'" in policy
        assert "unsafe" not in policy
        assert answer.headers["X-Content-Type-Options"] == "nosniff"
    strange = urllib.request.Request(server.place, headers={"Host": "evil.example"})
    with pytest.raises(urllib.error.HTTPError) as refused:
        urllib.request.urlopen(strange)
    refused.value.close()
    assert refused.value.code == 400
