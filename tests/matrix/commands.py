"""Commands that a user types for every example, and what they answer, in a form that two machines can compare
to the bit.

``python commands.py FOLDER`` carries all of them out, in one process, through the entry function of the
command line, and writes ``FOLDER/answers.json``: for each command its exit code, every number and text that
it prints, and a digest of every row of its run file. Left out is what differs between two runs of the same
command on one machine: times of the clock, sizes of files, paths.

``--processor`` has steps compiled for another processor of this kind, with its width of registers;
``--cores`` has so many cores reported; ``--other-libraries`` has the last bit of what libraries compute come
out otherwise (``libraries.py``).
"""

from __future__ import annotations

import argparse
import contextlib
import hashlib
import io
import json
import os
import shutil
import sys
import traceback
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
# Examples with a crank run for two turns, however long they are by themselves; the others as long as they
# say, or as SHORTER says. A second turn of jansen_leg_loose would take a tenth of the time of all commands.
CRANKED = (
    "compressor", "four_bar", "four_bar_case_b", "four_bar_case_c", "four_bar_ideal", "jansen_leg",
    "quick_return", "scotch_yoke", "six_bar_press", "slider_crank", "slider_crank_loose_guide",
    "slider_crank_loose_pin",
)  # fmt: skip
TURNS = 2
# Fewer loads of static analyses, and the first part of motions: a bit that differs changes all outputs after
# it.
SHORTER = {
    "elastica_circle": "run.load_factors=[0.25, 0.5]",
    "four_bar_loose": "run.duration=0.3 s",
    "lee_frame": "run.load_factors=[0.2, 0.4, 0.5]",
    "slider_crank_free": "run.duration=0.05 s",
    "williams_toggle": "run.load_factors=[0.1, 0.2328, 0.3922]",
}
# Keys of what is printed that no two runs share.
CLOCKED = {"wall_s", "ns_per_step", "run", "file", "estimate", "model_file", "seconds", "created", "versions"}
STUDY = """\
model = "{model}"
measures = ["C.force.max", "follower.angular_acceleration.max", "rms(C.force)", "crank.power.mean"]
turns = 1

[vary.clearance]
path = ["joint.B.clearance", "joint.C.clearance", "joint.D.clearance"]
from = "0.1 mm"
to = "0.3 mm"
count = 2

[vary.coupler]
path = "body.coupler.length"
from = "258 mm"
to = "262 mm"
count = 2
"""
CRASHED = 70  # exit code of a command that ends by an exception that nobody expected
DIGITS = 12  # of a digest, in hexadecimal

Numbers = dict[str, Any]


def examples() -> list[str]:
    """Names of the examples that are model files."""
    return sorted(path.stem for path in EXAMPLES.glob("*.toml"))


def commands(folder: Path) -> dict[str, list[list[str]]]:
    """What is typed, by name: one or several commands, the last of which prints what is compared."""
    found: dict[str, list[list[str]]] = {}
    for name in examples():
        model, length = str(EXAMPLES / f"{name}.toml"), ["--turns", str(TURNS)] if name in CRANKED else []
        length += ["--set", SHORTER[name]] if name in SHORTER else []
        found[f"check {name}"] = [["check", model, "--json"]]
        found[f"run {name}"] = [
            ["run", model, "-o", str(folder / name), "--force", "--quiet", "--json", *length]
        ]
    crank = str(EXAMPLES / "slider_crank.toml")
    found["sensitivity slider_crank"] = [
        ["sensitivity", crank, "--turns", "1", "--of", "*.moment.max", "--json", "--quiet"]
    ]
    bars = str(EXAMPLES / "four_bar_case_b.toml")
    found["sensitivity four_bar_case_b"] = [
        [
            "sensitivity",
            bars,
            "--turns",
            "1",
            "--of",
            "*.force.max",
            "--to",
            "body.coupler.*",
            "--json",
            "--quiet",
        ]
    ]
    study, plan = str(folder / "few.study"), str(folder / "few.toml")
    found["study four_bar_case_c"] = [
        ["study", plan, "-o", study, "--quiet"],
        ["study", "show", study, "--json"],
    ]
    over = [
        "--over",
        "joint.pin.clearance=0.2..0.3mm",
        "--count",
        "2",
        "--turns",
        "4",
        "--drop",
        "2",
        "--companions",
        "1",
    ]
    pin, target = str(EXAMPLES / "slider_crank_loose_pin.toml"), str(folder / "few.map")
    found["map slider_crank_loose_pin"] = [
        ["map", pin, *over, "-o", target, "--csv", str(folder / "map.csv"), "--quiet"]
    ]
    return found


def carry_out(folder: Path, names: list[str] | None = None, options: list[str] | None = None) -> Numbers:
    """The answers of the commands whose names are there, all of them if none is; ``options`` are added to
    each ``run``.
    """
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "few.toml").write_text(STUDY.format(model=EXAMPLES / "four_bar_case_c.toml"))
    answers = {}
    for name, typed in commands(folder).items():
        if names and not any(word in name.split() or word == name for word in names):
            continue
        for words in typed:
            code, printed, said = typed_in([*words, *(options or []) * (words[0] == "run")])
            if code:
                break
        answers[name] = {"exit": code, "printed": flat(read(printed)), **recorded(folder, name, code)}
        if code:
            answers[name]["said"] = said.replace(str(EXAMPLES), "").strip()
    return answers


def typed_in(words: list[str]) -> tuple[int, str, str]:
    """Exit code, standard output and standard error of a command, in this process."""
    from vfife.__main__ import main

    printed, said, code, before = io.StringIO(), io.StringIO(), 0, sys.argv
    sys.argv = ["vfife", *words]
    try:
        with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(said):
            main()
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else int(end.code is not None)
    except Exception:  # the other commands are to be compared all the same
        code = CRASHED
        said.write(traceback.format_exc())
    finally:
        sys.argv = before
    return code, printed.getvalue(), said.getvalue()


def read(printed: str) -> Any:
    """What was printed as JSON, or its lines."""
    try:
        return json.loads(printed)
    except ValueError:
        return printed.splitlines()


def flat(value: Any, path: str = "") -> Numbers:
    """Every number and text of nested JSON by its path, but those of ``CLOCKED``."""
    if isinstance(value, Mapping):
        inner: Iterator[tuple[str, Any]] = (
            (str(key), one) for key, one in value.items() if key not in CLOCKED
        )
    elif isinstance(value, list):
        inner = ((str(key), one) for key, one in enumerate(value))
    else:
        return {path: value}
    return {
        name: one for key, part in inner for name, one in flat(part, f"{path}/{key}" if path else key).items()
    }


def recorded(folder: Path, name: str, code: int) -> Numbers:
    """Digests of what the files of a command hold: rows by name, those of companions with them; a table as
    text.
    """
    kind, what = name.split(" ")
    if kind == "map" and not code:
        return {"table": flat(list((folder / "map.csv").read_text().splitlines()))}
    if kind != "run" or not (folder / what / "run.sqlite").exists():
        return {}
    return {"rows": {key: digest(values) for key, values in rows(folder / what).items()}}


def rows(run: Path) -> dict[str, Any]:
    """Each recorded row of a run by its name, shape (outputs,), and of companions and their turns."""
    import numpy as np

    from vfife.results.provenance import named_rows
    from vfife.simulation.result import Result

    record = Result.load(run).record

    def names(kept: Any) -> list[str]:
        return [
            f"{block}[{first + k}]"
            for block, (first, count) in named_rows(record.assembly, kept)
            for k in range(count)
        ]

    found = {"step number": np.asarray(record.steps)}
    found |= {name: record.rows[:, k] for k, name in enumerate(names(record.row_numbers))}
    left = record.companions
    if left is not None:
        found |= {f"companions' {name}": left.rows[:, k] for k, name in enumerate(names(left.row_numbers))}
        found["companions' turns"] = left.turns
    if record.estimate is not None:
        found |= {f"estimate {name}": np.array(error) for name, error in record.estimate.errors.items()}
    return found


def digest(values: Any) -> str:
    """Hash of numbers, to the bit and the sign of a zero."""
    import numpy as np

    kind = "<i8" if np.asarray(values).dtype.kind in "iu" else "<f8"
    return hashlib.sha256(np.ascontiguousarray(values, dtype=kind).tobytes()).hexdigest()[:DIGITS]


def pretend(processor: str, cores: int, other_libraries: bool) -> None:
    """Has the machine look like another one: its libraries, the processor that code is made for, and how many
    cores there are.
    """
    if other_libraries:
        sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
        from matrix.libraries import imitate

        imitate()
    if processor:
        from vfife.compiler.runtime import native

        widths = {
            "x86-64": "",
            "x86-64-v2": "",
            "x86-64-v3": "+avx,+avx2",
            "x86-64-v4": "+avx,+avx2,+avx512f",
        }
        native.processor = lambda: (processor, widths[processor])
    if cores:
        os.cpu_count = lambda: cores


def main() -> None:
    """The script."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--name", action="append", help="commands of this name, or of this example")
    parser.add_argument(
        "--option",
        action="append",
        help="one more word of each run, such as --option=--companions --option=3",
    )
    parser.add_argument("--processor", default="")
    parser.add_argument("--cores", type=int, default=0)
    parser.add_argument("--other-libraries", action="store_true")
    given = parser.parse_args()
    pretend(given.processor, given.cores, given.other_libraries)
    shutil.rmtree(given.folder, ignore_errors=True)
    answers = carry_out(given.folder, given.name, given.option)
    (given.folder / "answers.json").write_text(json.dumps(answers))


if __name__ == "__main__":
    main()
