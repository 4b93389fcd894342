"""The page that ships is the one that its sources make; no node is needed to know."""

from __future__ import annotations

import hashlib
import json
from importlib.resources import files
from pathlib import Path

import pytest

WEB = Path(__file__).parents[2] / "web"
SINGLE = ("index.html", "package.json", "package-lock.json", "tsconfig.json", "vite.config.ts")
PAGE = Path(str(files("rangeface.app") / "page"))

pytestmark = pytest.mark.skipif(not WEB.is_dir(), reason="no web/ here: an installed package")


def test_the_bundle_matches_its_sources():
    sources, bundle = (PAGE / "SOURCE").read_text().split()
    remedy = "run `npm ci && npm run build` in web/ and commit the page"
    assert digest(WEB, SINGLE, ("src", "public")) == sources, f"web/ has changed: {remedy}"
    assert digest(PAGE, ("index.html",), ("assets",)) == bundle, f"an edited bundle: {remedy}"


def digest(root: Path, files: tuple[str, ...], folders: tuple[str, ...]) -> str:
    """What `vite.config.ts` writes."""
    inside = [f"{folder}/{file.name}" for folder in folders for file in (root / folder).iterdir()]
    sha256 = hashlib.sha256()
    for name in sorted([*files, *inside]):
        sha256.update(f"{name}\n".encode() + (root / name).read_bytes() + b"\n")
    return sha256.hexdigest()


def test_the_bundle_names_no_other_host():
    allowed = ("http://www.w3.org/",)  # names of XML namespaces, which nobody fetches
    for name in ("index.html", "assets/page.css"):
        text = (PAGE / name).read_text(encoding="utf-8")
        for start in allowed:
            text = text.replace(start, "")
        assert "http" not in text


def test_versions_are_pinned_and_the_lock_names_no_registry():
    package = json.loads((WEB / "package.json").read_text())
    versions = {**package["dependencies"], **package["devDependencies"]}
    assert all(version[0].isdigit() for version in versions.values())
    assert '"resolved"' not in (WEB / "package-lock.json").read_text()


def test_the_licence_of_what_is_bundled_ships_with_it():
    assert "MIT License" in (PAGE / "LICENSE.three.txt").read_text(encoding="utf-8")
