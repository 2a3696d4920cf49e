// The drawing in the page around it: its tools, the fields of what is selected, drafts, undo.

const sketch = new Sketch($("paper"), $("bubble"), {
  send: (operation) => ask(at("sketch"), operation),
  keep,
  tell: (text) => {
    $("why").textContent = text;
  },
  showText: (text) => {
    if (document.activeElement !== $("text") && !session.pending.length) $("text").value = text;
  },
  select: showPart,
});

// Joints by the choice of their kind, in the words of the menus.
const KINDS = {
  ideal: "revolute",
  clearance: "revolute with clearance",
  slider: "slider, fixed angle",
  slot: "slider, turning",
  "clearance-slider": "slider with clearance",
  weld: "weld",
};
const CRANK = `name = "new mechanism"

[ground]
A = [0, 0]

[body.crank]
length = "100 mm"
mass = "0.1 kg"

[joint.A]
bearing = "ground.A"
journal = "crank.start"

[driver.crank]
speed = "60 rpm"
`;
const LETTERS = { v: "select", b: "body", p: "point", j: "joint", f: "force", r: "driver", x: "delete" };

const drawn = () => $("draw").getAttribute("aria-pressed") === "true";

// Make the text of an answer the model. A mechanism that does not close is a draft until it does; Undo takes its steps back.
async function keep(answer) {
  session.drafts = answer.fault ? [...(session.drafts ?? []), ...(session.draft ? [session.draft] : [])] : [];
  session.draft = answer.fault ? answer.text : null;
  $("undo").disabled = !session.draft && session.model.undo === 0;
  if (session.draft) {
    $("text").value = answer.text;
    return state("a draft that does not close; Undo goes back");
  }
  const made = await ask(at("text"), { text: answer.text, version: session.model.version, sketch: true });
  await changed(made);
  if (!made.ok) sketch.show(session.model.text);
}

async function draw(on = !drawn()) {
  $("draw").setAttribute("aria-pressed", String(on));
  $("stage").hidden = on;
  $("sketch").hidden = !on;
  if (!session.draft) tellState();
  if (on) {
    tab("text");
    if (matchMedia("(min-width: 62rem)").matches) await edit(true);
    await sketch.show(session.draft ?? session.model.text, true);
    sketch.fit();
  } else {
    if (session.unloaded) load();
    session.unloaded = false;
  }
}

async function undo(what) {
  sketch.hush();
  await sketch.queue;
  if (!session.draft) return changed(await ask(at(what), {}));
  if (what === "redo") return;
  session.draft = session.drafts.pop() ?? null;
  if (!session.draft) {
    untyped();
    tellState();
    $("undo").disabled = session.model.undo === 0;
  }
  return sketch.show(session.draft ?? session.model.text);
}

// Begin with a driven crank, which is the least that moves.
async function begin() {
  await open({ name: "mechanism.toml", text: CRANK });
  if (!session.model) return;
  await draw(true);
  sketch.view.scale *= 0.5; // room for more bodies
}

// -------------------------------------------------------------------------------------------------------------------- tools

function use(name) {
  sketch.use(name);
  for (const button of document.querySelectorAll("[data-tool]")) button.setAttribute("aria-pressed", String(button.dataset.tool === name));
  sketch.choose(name === "select" ? sketch.chosen : null);
}

function motion() {
  sketch.playing = !sketch.playing;
  $("motion").setAttribute("aria-pressed", String(sketch.playing));
}

const remove = (part) => sketch.remove(part, sketch.middle(part));

function letters(event) {
  const typing = ["INPUT", "TEXTAREA", "SELECT"].includes(event.target.tagName) || document.querySelector("dialog[open]");
  if (!drawn() || typing || event.ctrlKey || event.metaKey || event.altKey || !sketch.drawing) return;
  if (event.key === "Escape") use("select");
  else if (["Delete", "Backspace"].includes(event.key) && sketch.chosen) remove(sketch.chosen);
  else if (LETTERS[event.key]) use(LETTERS[event.key]);
  else if (event.key === " " && event.target.tagName !== "BUTTON") motion();
  else return;
  event.preventDefault();
}

// ------------------------------------------------------------------------------------------------- the part that is selected

// Field of a number, shown as a multiple `unit` of its SI value.
function numberField(name, unit, value, act) {
  const size = { mm: 1e-3, N: 1, rpm: Math.PI / 30, "°": Math.PI / 180 }[unit];
  const input = element("input", { value: Number((value / size).toPrecision(7)), autocomplete: "off" });
  input.setAttribute("aria-label", `${name} in ${unit}`);
  input.onchange = () =>
    input.value.trim() && Number.isFinite(Number(input.value)) ? act(size * Number(input.value), input.value) : input.focus();
  return element("label", {}, `${name} `, input, ` ${unit}`);
}

// A place (m) to the resolution in which lengths are written: a joint closes with rounded lengths and angles.
function written(value) {
  const step = sketch.drawing.resolution;
  return Number((Math.round(value / step) * step).toPrecision(12));
}

// Field of a number of a table of the model.
function valueField(label, unit, value, key, at) {
  return numberField(label, unit, value, (_, text) => sketch.apply("set_value", { ...key, value: `${text} ${unit}` }, at()));
}

// Field of the direction of a guide, from the x axis of the body that it belongs to.
function directionField(joint, [x, y], at) {
  return numberField("direction", "°", Math.atan2(y, x), (angle) => sketch.apply("set_direction", { joint, angle }, at));
}

function actButton(text, act) {
  const button = element("button", { type: "button", className: "small", textContent: text });
  button.onclick = act;
  return button;
}

function kindMenu(label, value, act) {
  const choices = sketch.drawing.choices.map((choice) => [choice, KINDS[choice] ?? choice]);
  if (!choices.some(([choice]) => choice === value)) choices.unshift([value, value]);
  const menu = element("select", {}, ...choices.map(([choice, text]) => element("option", { value: choice, textContent: text })));
  menu.setAttribute("aria-label", label);
  menu.value = value;
  menu.onchange = () => act(menu.value);
  return menu;
}

const PARTS = {
  knot: (knot) => {
    const [point] = knot.pins;
    const [x, y] = knot.at.map(written);
    const joints = sketch.drawing.joints.filter(({ name }) => knot.joints.includes(name));
    return [
      knot.pins.join(", "),
      numberField("x", "mm", x, (value) => sketch.apply("move_point", { point, x: value, y }, knot.at)),
      numberField("y", "mm", y, (value) => sketch.apply("move_point", { point, x, y: value }, knot.at)),
      ...joints.flatMap(({ name, choice, clearance, drivers, guide }) => [
        element("b", { textContent: name }),
        kindMenu(`kind of ${name}`, choice, (kind) => changeKind(name, kind, knot)),
        ...(clearance === null ? [] : [valueField("clearance", "mm", clearance, { section: "joint", name, key: "clearance" }, () => knot.at)]),
        ...(guide ? [directionField(name, guide, knot.at)] : []),
        ...drivers.map((driver) =>
          actButton(`Delete driver ${driver}`, () => sketch.apply("delete", { section: "driver", name: driver }, knot.at)),
        ),
        actButton(`Delete ${name}`, () => sketch.apply("delete", { section: "joint", name }, knot.at)),
      ]),
      ...(joints.length ? [] : [actButton(`Delete ${point}`, () => remove({ knot }))]),
    ];
  },
  body: (name) => {
    const { length, driver } = sketch.drawing.bodies.find((body) => body.name === name);
    const at = () => sketch.middle({ body: name });
    return [
      name,
      ...(length ? [numberField("length", "mm", length, (value) => sketch.apply("set_length", { body: name, length: value }, at()))] : []),
      ...(driver ? driverFields(driver) : [actButton("Drive it", () => sketch.apply("drive", { body: name }, at()))]),
      actButton(`Delete ${name}`, () => remove({ body: name })),
    ];
  },
  load: (name) => {
    const { force, at } = sketch.drawing.loads.find((load) => load.name === name);
    const set = (x, y) =>
      sketch.apply("set_value", { section: "load", name, key: "force", value: `["${x} N", "${y} N"]` }, sketch.drawing.place(at));
    const fields = Math.hypot(...force)
      ? [numberField("x", "N", force[0], (x) => set(x, force[1])), numberField("y", "N", force[1], (y) => set(force[0], y))]
      : [];
    return [`${name} at ${at}`, ...fields, actButton(`Delete ${name}`, () => remove({ load: name }))];
  },
  spring: (name) => [name, actButton(`Delete ${name}`, () => remove({ spring: name }))],
  driver: (name) => [`driver ${name}`, ...driverFields(sketch.drawing.bodies.find(({ driver }) => driver?.name === name).driver)],
};

function driverFields({ name, speed }) {
  const at = () => sketch.middle({ driver: name });
  return [
    ...(speed === null ? [] : [valueField("speed", "rpm", speed, { section: "driver", name, key: "speed" }, at)]),
    actButton("Delete the driver", () => remove({ driver: name })),
  ];
}

// A refused kind leaves the menu as it was.
async function changeKind(joint, choice, knot) {
  if (!(await sketch.apply("set_kind", { joint, choice }, knot.at))) sketch.choose(sketch.chosen);
}

// Show the fields of the selected part, or what the tool does.
function showPart(part) {
  const { tool } = sketch;
  const [kind, value] = Object.entries(part ?? {})[0] ?? [];
  const [title, ...fields] = kind ? PARTS[kind](value) : [];
  const parts = title ? [element("b", { textContent: title }), ...fields] : [element("span", { className: "hint", textContent: tool.hint })];
  if (tool.kind) {
    const menu = kindMenu("kind of the new joint", tool.kind, (choice) => {
      tool.kind = choice;
    });
    parts.unshift(element("label", {}, "kind ", menu));
  }
  $("chosen").replaceChildren(...parts);
}

document.addEventListener("keydown", letters);
for (const button of document.querySelectorAll("[data-tool]")) button.onclick = () => use(button.dataset.tool);
$("draw").onclick = () => draw();
$("undo").onclick = () => undo("undo");
$("redo").onclick = () => undo("redo");
$("motion").onclick = motion;
$("fit").onclick = () => sketch.fit();

opened();

// For whoever looks into the page with the browser's own tools; nothing in it uses this.
session.sketch = sketch;
window.shell = session;
