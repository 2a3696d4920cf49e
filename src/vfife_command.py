"""Entry of the command ``vfife``: from its first line on a signal ends the process without a traceback.

The package and what it imports take some hundredths of a second until :mod:`vfife.cli.signals` listens. Until
then Ctrl-C is to end the process as it ends any other, so Python's own handler, which raises
KeyboardInterrupt, is taken away. The module is not in the package, whose ``__init__`` would be imported
first, and it imports only what is compiled into the interpreter: ``signal`` itself would import ``enum``.
"""

import _signal

if _signal.getsignal(_signal.SIGINT) is _signal.default_int_handler:  # ignored, as by nohup, it stays ignored
    _signal.signal(_signal.SIGINT, _signal.SIG_DFL)


def main() -> None:
    """Run the command line."""
    from vfife.__main__ import main as run

    run()
