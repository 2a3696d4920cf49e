"""``vfife`` and ``python -m vfife``."""

from __future__ import annotations

import sys

from .cli import signals


def main() -> None:
    """Run the command line. Signal handlers are installed before it is loaded and remain until the process
    ends.
    """
    signals.listen()
    signals.JSON.wanted = "--json" in sys.argv
    try:
        from .cli.app import app

        app(prog_name="vfife")
    except BaseException as error:
        if signals.ENDING.heard and (
            not isinstance(error, SystemExit) or error.code == 1
        ):  # whatever a KeyboardInterrupt became on its way
            signals.end_at_once()
        raise
    finally:
        signals.flush_output()


if __name__ == "__main__":
    main()
