"""Who is answered: browsers on this machine that know the secret, and pages of our own.

The secret is a part of every address. A cookie would go to whatever else listens on another port of this machine, too.
"""

from __future__ import annotations

import secrets
from collections.abc import Iterable

from starlette.datastructures import Headers
from starlette.responses import PlainTextResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src 'self' data:; frame-src 'self'; base-uri 'none'; "
    "form-action 'none'; frame-ancestors 'none'"
)
WITHIN = "frame-ancestors 'self'"  # of a page in which a mechanism runs, which says itself what it may ask for: nothing
HEADERS = {
    "referrer-policy": "no-referrer",
    "x-content-type-options": "nosniff",
    "cross-origin-resource-policy": "same-origin",
    "cross-origin-opener-policy": "same-origin",
    "cache-control": "no-store",
}


class Guard:
    """Refuses, with 403, whoever calls by another name (a name of a foreign page that leads here), comes from a foreign page, or has no secret."""

    def __init__(self, app: ASGIApp, secret: str, hosts: Iterable[str]) -> None:
        self.app, self.secret, self.hosts = app, secret, frozenset(hosts)
        self.origins = frozenset(f"http://{host}" for host in self.hosts)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answers a request, or refuses it."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        if (why := self.refusal(scope)) is not None:
            await PlainTextResponse(f"vfife live: {why}\n", 403, HEADERS)(scope, receive, send)
            return

        async def marked(message: Message) -> None:
            if message["type"] == "http.response.start":
                given = list(message.get("headers", ()))
                known = {name for name, _ in given}
                ours = {**HEADERS, "content-security-policy": POLICY}
                message["headers"] = given + [(k.encode(), v.encode()) for k, v in ours.items() if k.encode() not in known]
            await send(message)

        _, secret, rest = scope["path"].split("/", 2)
        root = f"/{secret}"
        await self.app({**scope, "path": f"{root}/{rest}", "root_path": root}, receive, marked)

    def refusal(self, scope: Scope) -> str | None:
        """Why a request is refused; None for one that is answered."""
        headers = Headers(scope=scope)
        if headers.get("host", "") not in self.hosts:
            return "this name is not that of this machine"
        origin = headers.get("origin")
        if origin is not None and origin not in self.origins:
            return "a page from elsewhere asks"
        followed = scope["method"] == "GET" and headers.get("sec-fetch-dest") == "document"  # a link, as in a terminal that is a page itself
        if headers.get("sec-fetch-site", "none") not in ("same-origin", "none") and not followed:
            return "a page from elsewhere asks"
        if scope["method"] not in ("GET", "HEAD") and headers.get("content-type", "").partition(";")[0] != "application/json":
            return "what is sent is no JSON"
        parts = scope["path"].split("/", 2)
        if len(parts) < 3 or not secrets.compare_digest(parts[1].encode(), self.secret.encode()):
            return "the address is not the one that was printed when it was started; the secret in it is another"
        return None
