"""The service: `create_app` for any ASGI server, `rangeface serve` for a door.

One file a concern. Routes: `decisions` (identify, verify), `people` (enrol, list, delete, audit),
`operations` (health, status, metrics), `live` (the page and its WebSocket). Around them: `hosts`,
`keys`, `auth`, `sessions`, `attempts`, `rates`, `bodies` (limits), `problems` (RFC 9457),
`requests` (log and counts), `metrics`, `connections`. Behind them: `workers`, processes that read
scans (`worker`, `orders`, `messages`).
"""

from rangeface.app.server._app import create_app
from rangeface.app.server.settings import Settings

__all__ = ["Settings", "create_app"]
