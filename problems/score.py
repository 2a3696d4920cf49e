"""Compare the answer of any program with the certified references of these problems.

    python score.py four_bar answer.csv [--largest largest.csv]

An answer is a table with the column ``t`` (s) and any of the columns of reference.csv, at any of its times.
``--largest`` is a table with the columns ``quantity`` and ``largest``. The script needs Python alone.

For each column it prints the largest error, over the largest size of that column, until 10, 50 and 100 % of
the duration, and the time until which the error stays below 1e-3. What the reference itself does not know is
subtracted from no error: where its two integrations differ by more than a hundredth of an error, the row says
"not certain".
"""

from __future__ import annotations

import argparse
import csv
import math
import sys
from pathlib import Path

SHARES = (0.1, 0.5, 1.0)
NEAR = 1e-3
Table = dict[float, dict[str, float]]


def table(path: Path) -> Table:
    """Rows of a table by time (s), rounded to a picosecond."""
    with path.open(newline="") as file:
        reader = csv.DictReader(file)
        if reader.fieldnames is None or "t" not in reader.fieldnames:
            raise SystemExit(f"{path}: there is no column t (s)")
        try:
            return {
                round(float(row["t"]), 12): {name: float(value) for name, value in row.items() if name != "t"}
                for row in reader
            }
        except (TypeError, ValueError) as error:
            raise SystemExit(f"{path}, line {reader.line_num}: {error}") from None


def errors(reference: Table, answer: Table) -> list[dict[str, object]]:
    """For each column of the answer: its errors until parts of the duration, and how long it is near."""
    times = sorted(reference.keys() & answer.keys())
    if not times:
        raise SystemExit("no time of the answer is one of reference.csv")
    unknown = sorted(set(answer[times[0]]) - set(reference[times[0]]))
    if unknown:
        raise SystemExit(f"columns that reference.csv does not have: {', '.join(unknown)}")
    result, end = [], max(reference)
    for name in answer[times[0]]:
        size = max(abs(row[name]) for row in reference.values())
        apart = [(t, abs(answer[t][name] - reference[t][name]) / size, reference[t]["apart"]) for t in times]
        entry: dict[str, object] = {"column": name}
        for share in SHARES:
            part = [(error, doubt) for t, error, doubt in apart if t <= share * end * (1.0 + 1e-9)]
            worst, doubt = max(part, default=(math.nan, 0.0))
            entry[f"until {share * end:g} s"] = (
                worst if doubt <= 0.01 * worst or worst == 0.0 else "not certain"
            )
        far = [t for t, error, _ in apart if not error <= NEAR]
        entry["near until"] = far[0] if far else times[-1]
        result.append(entry)
    return result


def largest_errors(reference: Path, answer: Path) -> list[dict[str, object]]:
    """Errors of largest values over the reference's."""
    with reference.open(newline="") as file:
        known = {row["quantity"]: float(row["largest"]) for row in csv.DictReader(file)}
    with answer.open(newline="") as file:
        values = {row["quantity"]: float(row["largest"]) for row in csv.DictReader(file)}
    unknown = sorted(values.keys() - known.keys())
    if unknown:
        raise SystemExit(f"quantities that {reference} does not have: {', '.join(unknown)}")
    return [
        {"quantity": name, "reference": known[name], "answer": value, "error": value / known[name] - 1.0}
        for name, value in values.items()
    ]


def show(rows: list[dict[str, object]]) -> None:
    """Print rows below their names."""
    texts = [
        list(rows[0]),
        *([f"{x:.3g}" if isinstance(x, float) else str(x) for x in row.values()] for row in rows),
    ]
    widths = [max(map(len, column)) for column in zip(*texts, strict=True)]
    for text in texts:
        print("  ".join(word.rjust(width) for word, width in zip(text, widths, strict=True)))


def main(words: list[str]) -> None:
    """Read the command line and print both tables."""
    folder = Path(__file__).parent
    names = sorted(path.parent.name for path in folder.glob("*/reference.csv"))
    parser = argparse.ArgumentParser(description="Score an answer to a problem.")
    parser.add_argument("problem", choices=names)
    parser.add_argument("answer", type=Path)
    parser.add_argument("--largest", type=Path)
    options = parser.parse_args(words)
    show(errors(table(folder / options.problem / "reference.csv"), table(options.answer)))
    if options.largest:
        print()
        show(largest_errors(folder / options.problem / "largest.csv", options.largest))


if __name__ == "__main__":
    main(sys.argv[1:])
