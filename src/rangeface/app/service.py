"""`rangeface serve` and `rangeface key`, if the extra is installed."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import UTC, datetime, timedelta
from pathlib import Path

from rich.markup import escape

from rangeface.app.console import console
from rangeface.errors import ParameterError
from rangeface.io import read_camera

try:
    from rangeface.app.server.keys import KeyRing, Scope
    from rangeface.app.server.run import serve as run
    from rangeface.app.server.settings import Settings
except ModuleNotFoundError as error:
    raise ParameterError(f"pip install 'rangeface[app]' (no module {error.name})") from error


def serve(
    gallery: str,
    model: Path | None,
    *,
    fmr: float,
    camera: Path | None,
    unit: str | None,
    host: str,
    port: int,
    keys: Path,
    tls_certificate: Path | None,
    tls_key: Path | None,
    keep_frontal: bool,
    workers: int,
) -> None:
    """Serve until told to stop."""
    usual = None if camera is None else read_camera(camera).camera
    settings = Settings(
        keys=keys, fmr=fmr, camera=usual, unit=unit, keep_frontal=keep_frontal, workers=workers
    )
    run(gallery, model, settings, host=host, port=port, tls_certificate=tls_certificate,
        tls_key=tls_key)  # fmt: skip


def add_key(name: str, scopes: Sequence[str], keys: Path, days: float | None) -> None:
    """Make a key and print it."""
    unknown = sorted(set(scopes) - set(Scope))
    if unknown:
        raise ParameterError(f"scope: unknown {unknown[0]!r}; known: {', '.join(Scope)}")
    expires = None if days is None else datetime.now(UTC) + timedelta(days=days)
    text = KeyRing(keys).add(name, map(Scope, scopes), expires=expires)
    console.print(text, markup=False, highlight=False, soft_wrap=True)


def show_keys(keys: Path) -> None:
    """Print the keys, never their secrets."""
    for key in KeyRing(keys).all():
        until = f"until {key.expires:%Y-%m-%d %H:%M} UTC" if key.expires else "until revoked"
        scopes = ", ".join(sorted(key.scopes))
        console.print(f"{key.id}  {escape(key.name)}  {until}  {scopes}", highlight=False)


def revoke_key(identity: str, keys: Path) -> None:
    """Take a key out of the file."""
    KeyRing(keys).revoke(identity)
    console.print(f"revoked {escape(identity)}", highlight=False)
