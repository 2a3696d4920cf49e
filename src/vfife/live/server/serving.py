"""A session on a port of this machine, from its beginning to Ctrl-C."""

from __future__ import annotations

import logging
import secrets
import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import uvicorn

from .app import app
from .session import Session

HERE = "127.0.0.1"
PATIENCE = 20.0  # s until it has begun
LEFT = 0.8  # s that it has to end


@dataclass(frozen=True)
class Serving:
    """A session that answers at ``address``, on ``port``."""

    address: str
    port: int
    thread: threading.Thread

    def wait(self) -> None:
        """Until a signal interrupts it."""
        while self.thread.is_alive():
            self.thread.join(0.2)


def bound(port: int) -> socket.socket:
    """A socket on a port of this machine alone, 0 for one that is free. Raises ValueError where it is taken."""
    listening = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listening.bind((HERE, port))
        listening.listen(128)
    except (OSError, OverflowError) as error:
        listening.close()
        why = getattr(error, "strerror", None) or "there is no such port"
        raise ValueError(
            f"--port {port}: {why}; name another one from 1024 to 65535, or leave it out for one that is free"
        ) from None
    return listening


@contextmanager
def served(session: Session, port: int = 0) -> Iterator[Serving]:
    """A session while it is served, by a thread of its own; at the end connections are cut. Raises ValueError
    for a port that is taken.
    """
    logging.getLogger("uvicorn").addHandler(
        logging.NullHandler()
    )  # connections that are cut at the end are no news
    logging.getLogger("uvicorn").propagate = False
    listening = bound(port)
    port, secret = listening.getsockname()[1], secrets.token_urlsafe(24)
    hosts = (f"{HERE}:{port}", f"localhost:{port}")
    config = uvicorn.Config(
        app(session, secret, hosts), http="h11", ws="none", loop="asyncio", lifespan="on", log_config=None, access_log=False, server_header=False,
        proxy_headers=False, timeout_graceful_shutdown=0,
    )  # fmt: skip
    server = uvicorn.Server(config)
    thread = threading.Thread(target=server.run, kwargs={"sockets": [listening]}, name="serving", daemon=True)
    thread.start()
    try:
        waited = threading.Event()
        for _ in range(int(PATIENCE / 0.01)):
            if server.started or not thread.is_alive():
                break
            waited.wait(0.01)
        if not server.started:
            raise ValueError("it could not be served here")
        yield Serving(f"http://{HERE}:{port}/{secret}/", port, thread)
    finally:
        session.close()
        server.should_exit = server.force_exit = True
        thread.join(LEFT)
