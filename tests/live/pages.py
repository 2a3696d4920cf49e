"""Pages of a test, and their scripts run by node, with the little of a browser that numbers need."""

import base64
import json
import shutil
import subprocess

import numpy as np
import pytest

from vfife.live.page.page import BROWSER, page_with_sliders
from vfife.live.page.patches import slider_patches

needs_node = pytest.mark.skipif(shutil.which("node") is None, reason="needs node, which runs JavaScript")

NUMBERS = ("pieces.js", "numbers.js", "store.js")


def scripts_of(page: str) -> dict:
    """What a page was given, as its own script reads it."""
    text = page.split('<script type="application/json" id="given">', 1)[1].split("</script>", 1)[0]
    return json.loads(text)


def page_of(mechanism, slides=(), step=None) -> str:
    return page_with_sliders(slider_patches(mechanism, list(slides), step))


def bits_of(text: str, width: int) -> np.ndarray:
    """Rows of numbers that came as base64, as their bits."""
    return np.frombuffer(base64.b64decode(text), dtype=np.uint64).reshape(-1, width)


def run_by_node(page: str, body: str, tmp_path, worker=lambda text: text):
    """What ``body`` returns where the page's numbers are at hand: ``step(setting, outputs)`` gives the rows
    of both simulations.
    """
    given = scripts_of(page)
    parts = [
        f"const document = {{ getElementById: () => ({{ textContent: {json.dumps(json.dumps(given))} }}) }};",
        *((BROWSER / name).read_text("utf-8") for name in NUMBERS),
        "const perTurn = given.perTurn, own = given.own, ideal = given.ideal;",
        f"const text = {json.dumps(worker(given['worker']))};",
        """
const step = (setting, outputs) => {
  const posts = [];
  const self = { postMessage: (message) => posts.push(message) };
  const make = new Function("self", "setTimeout", text + "; return () => waiting;");
  const late = [];
  make(self, (call) => late.push(call));
  self.onmessage({ data: { kind: "given", given } });
  self.onmessage({ data: { kind: "begin", id: 1, vector: setting.vector, until: outputs } });
  while (late.length) late.shift()();
  const rows = (which) => {
    const parts = posts.filter((one) => one.which === which).map((one) => one.rows);
    const found = new Float64Array(parts.reduce((sum, part) => sum + part.length, 0));
    parts.reduce((at, part) => (found.set(part, at), at + part.length), 0);
    return found;
  };
  return [rows(0), rows(1), posts];
};
const bits = (values) => Buffer.from(Float64Array.from(values).buffer).toString("base64");
""",
        f"console.log(JSON.stringify((() => {{ {body} }})()));",
    ]
    path = tmp_path / "page.js"
    path.write_text("\n".join(parts), "utf-8")
    found = subprocess.run(
        ["node", "--max-old-space-size=2000", str(path)], capture_output=True, text=True, check=False
    )
    assert found.returncode == 0, found.stderr[-3000:]
    return json.loads(found.stdout)
