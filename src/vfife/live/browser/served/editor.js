// The drawing in the page around it: its tools, the fields of what is selected, drafts, undo.

const sketch = new Sketch($("paper"), {
  send: async (operation) => {
    const answer = await ask(at("sketch"), operation);
    if (answer.ok && operation.operation && document.activeElement !== $("text")) $("text").value = answer.said.text;
    return answer;
  },
  keep,
  tell: (text) => {
    $("why").textContent = text;
  },
  select: chosen,
});

const drawn = () => $("draw").getAttribute("aria-pressed") === "true";

// Make the text of an answer the model. A mechanism that does not close is a draft until it does; Undo drops it.
async function keep(answer) {
  here.draft = answer.fault ? answer.text : null;
  $("undo").disabled = !here.draft && here.model.undo === 0;
  if (here.draft) {
    $("text").value = answer.text;
    return state("a draft that does not close; Undo drops it");
  }
  const made = await ask(at("text"), { text: answer.text, version: here.model.version, sketch: true });
  await changed(made);
  if (!made.ok) sketch.show(here.model.text);
}

async function draw(on = !drawn()) {
  $("draw").setAttribute("aria-pressed", String(on));
  $("stage").hidden = on;
  $("sketch").hidden = !on;
  if (on) {
    tab("text");
    if (matchMedia("(min-width: 62rem)").matches) await edit(true);
    await sketch.show(here.draft ?? here.model.text, true);
    sketch.fit();
  } else {
    if (here.unloaded) load();
    here.unloaded = false;
  }
}

async function undo(what) {
  if (here.draft) {
    here.draft = null;
    untyped();
    tellState();
    $("undo").disabled = here.model.undo === 0;
    return sketch.show(here.model.text);
  }
  return changed(await ask(at(what), {}));
}

// Fields of what is selected in the drawing.
function chosen(one) {
  const { drawing } = sketch;
  const number = (name, value, act) => {
    const input = element("input", { value: Number((1e3 * value).toPrecision(7)), autocomplete: "off" });
    input.setAttribute("aria-label", `${name} in mm`);
    input.onchange = () => (Number.isFinite(Number(input.value)) ? act(Number(input.value) / 1e3) : input.focus());
    return element("label", {}, `${name} `, input, " mm");
  };
  const parts = [];
  if (one?.knot) {
    const [point] = one.knot.pins;
    const [x, y] = one.knot.at;
    parts.push(element("b", { textContent: one.knot.pins.join(", ") }));
    parts.push(number("x", x, (value) => sketch.apply("move_point", { point, x: value, y })));
    parts.push(number("y", y, (value) => sketch.apply("move_point", { point, x, y: value })));
  }
  if (one?.body) {
    const body = drawing.bodies[drawing.index.get(one.body)];
    parts.push(element("b", { textContent: body.name }));
    if (body.length) parts.push(number("length", body.length, (length) => sketch.apply("set_length", { body: body.name, length })));
  }
  if (!parts.length) parts.push("Drag a point or the diamond of a length; the wheel zooms.");
  $("chosen").replaceChildren(...parts);
}

$("draw").onclick = () => draw();
$("undo").onclick = () => undo("undo");
$("redo").onclick = () => undo("redo");
$("motion").onclick = () => {
  sketch.playing = !sketch.playing;
  $("motion").setAttribute("aria-pressed", String(sketch.playing));
};
$("fit").onclick = () => sketch.fit();

opened();

// For whoever looks into the page with the browser's own tools; nothing in it uses this.
here.sketch = sketch;
window.shell = here;
