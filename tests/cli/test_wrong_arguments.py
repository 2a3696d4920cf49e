"""Public functions raise the error of the project, in one sentence, for a second argument of another type."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import vfife
from vfife.modelfile import loads

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
CRANK = EXAMPLES / "slider_crank.toml"
WRONG: dict[str, Any] = {
    "mapping": {"run.turns": 3}, "whole number": 5, "truth value": True, "object": object(), "bytes": b"x",
    "list of numbers": [1, 2], "list of triples": [("a", "b", "c")], "numbers by path": {1: 2},
}  # fmt: skip
CALLS: dict[str, tuple[Callable[[Any], Any], set[str]]] = {  # with what is right
    "load": (lambda value: vfife.load(CRANK, value), {"mapping"}),
    "load, set": (lambda value: vfife.load(CRANK, set=value), set()),
    "load_model": (lambda value: vfife.load_model(CRANK, value), set()),
    "loads": (lambda value: loads(CRANK.read_text(encoding="utf-8"), value), set()),
    "sensitivity, of": (lambda value: vfife.sensitivity(vfife.load(CRANK), value), set()),
    "sensitivity, to": (lambda value: vfife.sensitivity(vfife.load(CRANK), ["*.force.max"], value), set()),
    "study": (lambda value: vfife.study(vfife.load(CRANK), value, ["pin.force.max"], turns=1), set()),
    "study, measures": (
        lambda value: vfife.study(vfife.load(CRANK), {"body.crank.length": [0.1]}, value, turns=1),
        set(),
    ),
    "compare": (lambda value: vfife.compare(vfife.load(CRANK), value), set()),
    "fit": (lambda value: vfife.fit(vfife.load(CRANK), value, ["body.crank.length"]), set()),
    "design": (lambda value: vfife.design(vfife.gallery.four_bar_case_b(), value), set()),
    "wear": (
        lambda value: vfife.wear(vfife.gallery.four_bar_case_b(), value),
        {"whole number", "truth value"},
    ),
    "bifurcation": (lambda value: vfife.bifurcation(vfife.load(CRANK), value, 0.1, 0.2), set()),
    "save_model": (lambda value: vfife.save_model(vfife.load(CRANK), value), set()),
    "load_result": (vfife.load_result, set()),
    "resume": (vfife.resume, set()),
}


@pytest.mark.parametrize(("function", "kind"), [(name, kind) for name in CALLS for kind in WRONG])
def test_a_second_argument_of_another_type_is_a_sentence(function: str, kind: str, tmp_path: Path) -> None:
    call, right = CALLS[function]
    if kind in right:
        return
    with pytest.raises(vfife.VfifeError) as error:
        call(WRONG[kind])
    assert str(error.value).strip() and "Traceback" not in str(error.value)


def test_load_model_names_what_takes_a_mapping() -> None:
    with pytest.raises(vfife.VfifeError, match=r"pairs of a path and a value.*load\(path, \{\.\.\.\}\)"):
        vfife.load_model(CRANK, {"run.turns": 3})  # type: ignore[arg-type]
    assert vfife.load_model(CRANK, [("run.turns", 3)]).settings.turns == 3.0
    assert vfife.load_model(CRANK, iter([["run.turns", 3]])).settings.turns == 3.0
