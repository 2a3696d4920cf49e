"""Workbooks of spreadsheets (.xlsx, ECMA-376): a zip of XML with tables as sheets, without formulas and
styles.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping
from itertools import chain
from numbers import Integral, Real
from typing import Any, BinaryIO
from xml.sax.saxutils import escape, quoteattr
from zipfile import ZIP_DEFLATED, ZipFile, ZipInfo

from ..errors import VfifeError

MOST_ROWS, MOST_COLUMNS = 1_048_576, 16_384  # of a sheet, in every program that reads one
LONGEST_TITLE = 31  # letters of a title of a sheet
LARGEST = 2_000_000_000  # bytes of a sheet before it is packed, beyond which not every program unpacks it
HEAD = '<?xml version="1.0" encoding="UTF-8" standalone="yes"?>\n'
FORMATS = "http://schemas.openxmlformats.org"
MAIN = f"{FORMATS}/spreadsheetml/2006/main"
RELATION = f"{FORMATS}/officeDocument/2006/relationships"
TYPE = "application/vnd.openxmlformats-officedocument.spreadsheetml"
NOT_XML = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\ud800-\udfff\ufffe\uffff]")
UNIT = re.compile(r"(.+) \[([^][]+)\]")


def write_workbook(stream: BinaryIO, tables: Mapping[str, Iterable[Iterable[Any]]]) -> None:
    """Write tables by the titles of their sheets into a stream: heads first, and below them a row of units if
    a head has one, as in ``C.force [N]``.

    Numbers have all their digits; NaN is #N/A and infinity a text, because sheets have neither. Raises
    VfifeError for a table with more rows or columns than a sheet holds.
    """
    titles = _titles(tables)
    with ZipFile(stream, "w", ZIP_DEFLATED) as archive:
        for name, content in _frame(titles):
            archive.writestr(_part(name), HEAD + content)
        for number, (title, rows) in enumerate(zip(titles, tables.values(), strict=True), 1):
            with archive.open(_part(f"xl/worksheets/sheet{number}.xml"), "w") as sheet:
                size = 0
                for text in _sheet(rows, title):
                    size += sheet.write(text.encode("utf-8"))
                    if size > LARGEST:
                        raise VfifeError(f"the table {title!r} takes more than 2 GB in a sheet; write .csv")


def _part(name: str) -> ZipInfo:
    """Return the entry of a part, without a date: the same tables give the same bytes."""
    part = ZipInfo(name)
    part.compress_type = ZIP_DEFLATED
    return part


def _titles(tables: Iterable[str]) -> list[str]:
    """Return titles without the characters that no sheet may have, and each but once."""
    titles: dict[str, str] = {}  # by the part that a spreadsheet distinguishes
    for table in tables:
        plain = _text(re.sub(r"[][:*?/\\]", " ", table)).strip("' ")[:LONGEST_TITLE] or "table"
        title, k = plain, 2
        while title.casefold() in titles:
            title, k = f"{plain[: LONGEST_TITLE - 2]} {k}", k + 1
        titles[title.casefold()] = title
    return list(titles.values())


def _frame(titles: list[str]) -> Iterator[tuple[str, str]]:
    """Yield name and content of the parts that say where the sheets are."""
    numbers = range(1, len(titles) + 1)
    types = "".join(
        f'<Override PartName="/xl/worksheets/sheet{k}.xml" ContentType="{TYPE}.worksheet+xml"/>'
        for k in numbers
    )
    yield (
        "[Content_Types].xml",
        f'<Types xmlns="{FORMATS}/package/2006/content-types">'
        '<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>'
        f'<Override PartName="/xl/workbook.xml" ContentType="{TYPE}.sheet.main+xml"/>{types}</Types>',
    )
    yield "_rels/.rels", _relations([("officeDocument", "xl/workbook.xml")])
    yield (
        "xl/_rels/workbook.xml.rels",
        _relations([("worksheet", f"worksheets/sheet{k}.xml") for k in numbers]),
    )
    sheets = "".join(
        f'<sheet name={quoteattr(title)} sheetId="{k}" r:id="rId{k}"/>'
        for k, title in zip(numbers, titles, strict=True)
    )
    yield (
        "xl/workbook.xml",
        f'<workbook xmlns="{MAIN}" xmlns:r="{RELATION}"><sheets>{sheets}</sheets></workbook>',
    )


def _relations(targets: list[tuple[str, str]]) -> str:
    lines = "".join(
        f'<Relationship Id="rId{k}" Type="{RELATION}/{kind}" Target="{target}"/>'
        for k, (kind, target) in enumerate(targets, 1)
    )
    return f'<Relationships xmlns="{FORMATS}/package/2006/relationships">{lines}</Relationships>'


def _sheet(rows: Iterable[Iterable[Any]], title: str) -> Iterator[str]:
    """Yield the XML of a sheet, whose heads stay in sight."""
    remaining = iter(rows)
    heads = [str(head) for head in next(remaining, ())]
    parted = [UNIT.fullmatch(head) for head in heads]
    top: list[Iterable[Any]] = [heads]
    if any(parted):
        top = [
            [head if match is None else match[1] for head, match in zip(heads, parted, strict=True)],
            ["" if match is None else match[2] for match in parted],
        ]
    if len(heads) > MOST_COLUMNS:
        raise VfifeError(
            f"the table {title!r} has {len(heads):,} columns and a sheet holds {MOST_COLUMNS:,}; write .csv"
        )
    yield (
        f'{HEAD}<worksheet xmlns="{MAIN}"><sheetViews><sheetView workbookViewId="0"><pane ySplit="{len(top)}"'
        f' topLeftCell="A{len(top) + 1}" activePane="bottomLeft" state="frozen"/></sheetView></sheetViews>'
        "<sheetData>"
    )
    for number, row in enumerate(chain(top, remaining), 1):
        if number > MOST_ROWS:
            raise VfifeError(
                f"the table {title!r} has more rows than the {MOST_ROWS:,} of a sheet; write .csv"
            )
        yield f"<row>{''.join(map(_cell, row))}</row>"
    yield "</sheetData></worksheet>"


def _cell(value: Any) -> str:
    match value:
        case None | "":
            return "<c/>"
        case bool():
            return f'<c t="b"><v>{value:d}</v></c>'
        case Integral():
            return f"<c><v>{int(value)}</v></c>"
        case Real() if math.isfinite(value):
            return f"<c><v>{float(value)!r}</v></c>"
        case Real() if math.isnan(value):
            return '<c t="e"><v>#N/A</v></c>'
        case _:
            return f'<c t="inlineStr"><is><t xml:space="preserve">{escape(_text(value))}</t></is></c>'


def _text(value: Any) -> str:
    """Return a text without the characters that XML has not."""
    return NOT_XML.sub("\ufffd", str(value))
