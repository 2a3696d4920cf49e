"""Every example under every setting: do all of them answer the commands of a user to the bit?

``make matrix`` carries it out. The exit code is 1 where anything differs; the first quantity of each command
that does is printed. What this machine answers as it is, is compared with ``answers.json``, too.
``python tests/matrix/matrix.py --example compressor --setting Nehalem`` takes some;
``--option=--companions --option=0`` adds words to each run. ``--take`` writes what this machine answers into
``answers.json``, which the tests hold every machine to.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import shutil
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from matrix.differences import differences, first_row
from matrix.settings import Setting, answers, carried_out, settings

KEPT = Path(__file__).with_name("answers.json")
DIGITS = 6  # of a digest, in hexadecimal


def compacted(answers: dict[str, dict[str, object]]) -> dict[str, dict[str, object]]:
    """Answers with one short digest of every measure with its range, of every block of rows, and of what else
    is printed together.
    """

    def short(values: object) -> object:
        if not isinstance(values, dict):
            return values
        groups: dict[str, list[object]] = {}
        for key, value in values.items():
            parts = key.split("/")
            group = (
                parts[1]
                if parts[0] in ("measures", "ranges")
                else key.partition("[")[0]
                if "[" in key
                else parts[0]
            )
            groups.setdefault(group, []).append((key, value))
        return {
            name: hashlib.sha256(repr(some).encode()).hexdigest()[:DIGITS] for name, some in groups.items()
        }

    return {name: {kind: short(values) for kind, values in one.items()} for name, one in answers.items()}


def take(folder: Path) -> None:
    """Writes the answers of this machine as those that all machines are held to, a line for each command."""
    every = compacted(answers(carried_out(settings()[0], folder), folder))
    lines = ",\n".join(
        f"{json.dumps(name)}: {json.dumps(one, separators=(',', ':'))}" for name, one in every.items()
    )
    KEPT.write_text(f"{{\n{lines}\n}}\n")
    print(f"{len(every)} answers kept in {KEPT}")


def compared(
    some: list[Setting], names: list[str] | None, options: list[str] | None, folder: Path
) -> dict[str, list[str]]:
    """What differs from the first setting, by the name of each other one."""
    waiting, running, ended = list(enumerate(some)), {}, {}
    base: dict[str, dict[str, object]] | None = None
    found: dict[str, list[str]] = {}
    while waiting or running or ended:
        # The first fills the cache of compiled steps, which others read: until it has ended, only what
        # compiles steps of its own goes beside it.
        while len(running) < max(1, os.cpu_count() or 1):
            ready = (one for one in waiting if base is not None or one[0] == 0 or one[1].compiles)
            if (following := next(ready, None)) is None:
                break
            waiting.remove(following)
            k, setting = following
            running[k] = setting, carried_out(setting, folder / str(k), names, options), time.monotonic()
        for k in [k for k, (_, process, _) in running.items() if process.poll() is not None]:
            setting, process, began = running.pop(k)
            ended[k] = setting, answers(process, folder / str(k)), time.monotonic() - began
        if base is None and 0 in ended:
            base = ended.pop(0)[1]
            if names is None and options is None:
                kept = json.loads(KEPT.read_text())
                found["answers that are kept"] = [str(one) for one in differences(kept, compacted(base))]
                report("answers that are kept", found["answers that are kept"], len(base))
        while base is not None and ended:
            k, (setting, heard, seconds) = ended.popitem()
            found[setting.name] = [told(one, folder, k) for one in differences(base, heard)]
            report(f"{setting.name} ({seconds:.0f} s)", found[setting.name], len(base))
            shutil.rmtree(folder / str(k))
        time.sleep(0.1)
    return found


def report(name: str, lines: list[str], count: int) -> None:
    """Print how many commands answer otherwise under a setting, and what differs."""
    print(f"{name}: {len(lines)} of {count} commands differ", flush=True)
    for line in lines:
        print(f"    {line}", flush=True)


def told(difference: object, folder: Path, k: int) -> str:
    """A difference with the first row in which the runs of the command differ."""
    kind, name = str(getattr(difference, "command", "")).split(" ")
    row = first_row(folder / "0" / name, folder / str(k) / name) if kind == "run" else ""
    return f"{difference}" + (f"\n        {row}" if row else "")


def main() -> int:
    """The script."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--example", action="append", help="some commands only: of this example, or of this kind"
    )
    parser.add_argument("--setting", action="append", help="settings whose names hold this text")
    parser.add_argument("--option", action="append", help="one more word of each run")
    parser.add_argument("--take", action="store_true", help="write answers.json")
    given = parser.parse_args()
    if given.take:
        with tempfile.TemporaryDirectory(prefix="vfife-matrix-") as folder:
            take(Path(folder))
        return 0
    every = settings()
    some = [
        every[0],
        *(one for one in every[1:] if not given.setting or any(word in one.name for word in given.setting)),
    ]
    began = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="vfife-matrix-") as folder:
        found = compared(some, given.example, given.option, Path(folder))
    unlike = {name: lines for name, lines in found.items() if lines}
    print(
        f"{len(found)} comparisons with this machine as it is: {len(unlike)} find something else "
        f" ({time.monotonic() - began:.0f} s)"
    )
    return 1 if unlike else 0


if __name__ == "__main__":
    sys.exit(main())
