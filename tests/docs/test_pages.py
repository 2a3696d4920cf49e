"""What makes the pages: every key, law, mechanism and public name has its place, and a link that leads
nowhere, or elsewhere, is told.
"""

import importlib
import json
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest

import vfife

ROOT = Path(__file__).parents[2]


NAMES = ("tables", "command_reference", "law_gallery", "links", "mechanisms", "model_reference", "public_api")


@pytest.fixture
def docs(monkeypatch: pytest.MonkeyPatch) -> Iterator[dict[str, ModuleType]]:
    """The modules of docs/extensions that do without Sphinx."""
    monkeypatch.syspath_prepend(str(ROOT / "docs" / "extensions"))
    others = {
        name: sys.modules.pop(name) for name in NAMES if name in sys.modules
    }  # of tests, by the same name
    yield {name: importlib.import_module(name) for name in NAMES}
    for name in NAMES:
        sys.modules.pop(name, None)
    sys.modules.update(others)


Docs = dict[str, ModuleType]


def test_the_reference_has_every_table_and_key_of_the_schema(docs: Docs) -> None:
    page, schema = (
        docs["model_reference"].page(),
        json.loads(docs["model_reference"].SCHEMA.read_text(encoding="utf-8")),
    )
    told = set(re.findall(r"^\| `(\w+)` \|", page, re.M))
    for table in (one for name, one in schema["definitions"].items() if name.endswith("Table")):
        assert page.count(f"`{table['description'].partition(': ')[0]}`") >= 1
        assert set(table["properties"]) <= told
    words = "radial: bearing radius less journal radius, half of the difference of the diameters"
    assert f"| `clearance` | {words} | m, above 0 m | must be given |" in page


def test_a_bar_in_an_option_borders_no_cell(docs: Docs) -> None:
    page = docs["command_reference"].page()
    assert r"`--at ANGLE\|TIME`" in page
    rows = [line for line in page.splitlines() if line.startswith("|")]
    assert len(rows) > 300 and {len(re.findall(r"(?<!\\)\|", row)) for row in rows} == {4}


def test_every_model_file_has_a_page_and_every_page_a_family(docs: Docs) -> None:
    page = docs["mechanisms"].first_page()
    for path in (ROOT / "examples").glob("*.toml"):
        assert f'href="{path.stem}.html"' in page
        assert f'src="../live/{path.stem}.html"' in docs["mechanisms"].page(path.stem)


def test_what_is_typed_in_a_models_head_is_code_and_signs_are_signs(docs: Docs) -> None:
    said = docs["mechanisms"].prose('a*b_c; try --set joint.C.clearance="40 um".')
    assert said == 'a\\*b\\_c; try `--set joint.C.clearance="40 um"`.'


def test_every_public_name_is_on_one_page_and_every_law_in_the_gallery(docs: Docs) -> None:
    listed = [name for names in docs["public_api"].by_group().values() for name in names]
    assert set(vfife.__all__) <= set(listed) and len(set(listed)) == len(listed)
    assert {"laws.Hertz", "joints.ClearanceRevolute", "studies.tolerance", "dynamics.basins"} <= set(listed)
    page = docs["law_gallery"].page()
    assert all(f"### {law['name']}\n" in page for law in docs["law_gallery"].told())


def test_every_public_name_has_a_sentence_at_the_head_of_its_page(docs: Docs) -> None:
    api = docs["public_api"]
    for group, names in api.by_group().items():
        page = api.page(*api.GROUPS[group], names)
        for name in names:
            (sentence,) = re.findall(rf"^   \* - `{re.escape(name)}`_\n     - (.+)$", page, re.M)
            assert len(sentence.split()) >= 2 and sentence.endswith("."), (name, sentence)


def test_links_that_lead_nowhere_and_what_is_loaded_from_elsewhere_are_told(
    docs: Docs, tmp_path: Path
) -> None:
    (tmp_path / "in").mkdir()
    (tmp_path / "in/b.html").write_text('<h1 id="there">b</h1><a href="https://example.org">out</a>')
    (tmp_path / "a.html").write_text(
        '<a href="in/b.html#there">1</a><a href="in/b.html#not">2</a><a href="c.html">3</a><img'
        ' src="x.png"><a href="#none">4</a><script src="https://cdn.example.org/x.js"></script><link'
        ' rel="stylesheet" href="//fonts.example.org/x.css"><link rel="next" href="z">'
    )
    assert docs["links"].faults(tmp_path) == [
        "a.html: in/b.html#not: there is no such place on in/b.html",
        "a.html: c.html leads nowhere",
        "a.html: x.png leads nowhere",
        "a.html: #none: there is no such place on a.html",
        "a.html: https://cdn.example.org/x.js is loaded from elsewhere",
        "a.html: //fonts.example.org/x.css is loaded from elsewhere",
    ]
