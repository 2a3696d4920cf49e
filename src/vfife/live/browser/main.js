// The page: clock, controls, cards, keys.

const $ = (id) => document.getElementById(id);
const selected = { joint: null, body: null, quantity: "angle" };
const showMessage = (text) => {
  $("told").textContent = text;
};

readTheme();
selected.joint = given.contacts[0]?.joint ?? Object.keys(own.joints)[0] ?? null;
selected.body = (turning.at(-1) ?? given.bodies.at(-1)).name;

const scene = new Scene();
const running = new Running();
let comparison = null; // the setting that is kept to compare with
const reducedMotion = matchMedia("(prefers-reduced-motion: reduce)").matches;
const clock = { head: perTurn ?? 0, wanted: 0, begun: 0, playing: !reducedMotion, speed: 1, last: 0, dragged: false, sized: false };
const wholeTurns = perTurn ?? wholeRun;
const firstUntil = perTurn ? (TURNS - 1) * perTurn + 1 : wholeRun + 1;
const MOST_COVERED = 0.08; // of the size: larger clearance circles after a change of a slider are drawn smaller
const sliders = new Sliders($("slides"), changed);

function changed(setting) {
  if (perTurn) clock.head = perTurn * Math.min(Math.floor(clock.head / perTurn), 1) + (clock.head % perTurn);
  else clock.head = Math.min(clock.head, wholeRun);
  clock.wanted = clock.head;
  clock.begun = performance.now();
  showMessage("");
  const until = Math.max(firstUntil, Math.ceil(clock.head + AHEAD * wholeTurns));
  running.begin(setting, until);
  comparison?.begin(comparison.setting, until); // the outputs of this moment may be kept no longer
  if (clock.sized && Math.log10(scene.magnify) > suitableMagnify(MOST_COVERED)) setMagnify(suitableMagnify());
  dirty(true);
}

// ------------------------------------------------------------------------------------------------------------------ cards

const cards = [
  { id: "forces", title: "Joint forces over the crank angle", draw: drawForces, when: Boolean(selected.joint), choose: ["joint"] },
  { id: "path", title: "Load path", draw: drawPath, when: Boolean(factors), choose: ["body", "quantity"] },
  { id: "orbits", title: "Journals in their bearings", draw: drawOrbits, when: given.contacts.length > 0, choose: [] },
  { id: "phase", title: "Phase portrait", draw: drawPhase, when: !factors, choose: ["body", "quantity"] },
  { id: "spectrum", title: "Spectrum of the force", draw: drawSpectrum, when: Boolean(selected.joint) && !factors, choose: ["joint"] },
  { id: "energy", title: "Energy", draw: drawEnergy, when: !factors, choose: [], note: true },
].filter(({ when }) => when);
if (!perTurn && cards[0]?.id === "forces") cards[0].title = factors ? "Joint forces along the load path" : "Joint forces over time";

const OPTIONS = {
  joint: () => [...Object.keys(own.joints), ...Object.keys(own.torques).map((name) => TORQUE + name)],
  body: () => given.bodies.map((body) => body.name),
  quantity: () => Object.keys(QUANTITIES),
};

function button(text, title, act) {
  const made = document.createElement("button");
  Object.assign(made, { type: "button", className: "small", textContent: text, title });
  made.setAttribute("aria-label", title);
  made.onclick = act;
  return made;
}

function choice(kind) {
  const list = document.createElement("select");
  list.setAttribute("aria-label", kind);
  list.dataset.kind = kind;
  for (const name of OPTIONS[kind]()) list.append(Object.assign(document.createElement("option"), { value: name, textContent: name }));
  list.value = selected[kind];
  list.onchange = () => select(kind, list.value);
  return list;
}

function select(kind, value) {
  selected[kind] = value;
  for (const list of document.querySelectorAll(`select[data-kind="${kind}"]`)) list.value = value;
  dirty(true);
}

for (const card of cards) {
  const figure = document.createElement("figure");
  figure.id = card.id;
  const head = document.createElement("figcaption");
  const title = document.createElement("h2");
  title.textContent = card.title;
  card.canvas = document.createElement("canvas");
  card.canvas.setAttribute("role", "img");
  card.canvas.setAttribute("aria-label", card.title);
  card.line = document.createElement("i");
  card.line.className = "moment";
  const png = button("PNG", `${card.title} as PNG`, () => {
    forFile(() => drawCard(card, true));
    handPng(card.canvas, fileName(`_${card.id}.png`));
  });
  const drawn = (pen, width, height) => forFile(() => card.draw(pen, width, height, running, clock.head, comparison));
  const svg = button("SVG", `${card.title} as SVG`, () => hand(fileName(`_${card.id}.svg`), svgOf(card.canvas, drawn), "image/svg+xml"));
  head.append(title, ...card.choose.map(choice), png, svg);
  figure.append(head, card.canvas, card.line);
  if (card.note) {
    card.note = document.createElement("p");
    figure.append(card.note);
  }
  $("cards").insertBefore(figure, $("peaks"));
}

// Charts are redrawn one per frame, so that they do not delay the picture of the mechanism.
let stale = [];
let staleAt = 0;
let spentOnCharts = 0; // ms of the last round

function dirty(now = false) {
  if (now) staleAt = 0;
}

function drawStale(time) {
  // A round begins so seldom that charts take at most a sixth of the time, on any machine.
  if (
    !stale.length &&
    time - staleAt > Math.max(clock.playing ? 220 : 120, 6 * spentOnCharts) &&
    (clock.playing || staleAt === 0 || running.store.end < running.until)
  ) {
    stale = [...cards, { id: "peaks" }];
    staleAt = time;
    spentOnCharts = 0;
  }
  const card = stale.shift();
  if (!card) return;
  const entered = performance.now();
  drawCard(card);
  spentOnCharts += performance.now() - entered;
}

function drawCard(card, unseen = false) {
  if (card.id === "peaks") return writePeaks($("peak-table"), running, comparison);
  const box = card.canvas.getBoundingClientRect();
  if (!unseen && (box.bottom < 0 || box.top > window.innerHeight)) return;
  const made = canvasFor(card.canvas);
  if (!made || !running.store.end) return;
  card.moment = card.draw(made.pen, made.width, made.height, running, clock.head, comparison?.store.end ? comparison : null);
  if (card.note) card.note.textContent = ledgerText(running, clock.head);
}

// Draw for a file, which has the moment in its picture.
function forFile(draw) {
  Axes.forFile = true;
  draw();
  Axes.forFile = false;
}

// Move the lines of the moment in view over the charts.
function followMoment(head) {
  for (const { canvas, line, moment } of cards) {
    line.hidden = !moment;
    if (!moment) continue;
    line.style.height = `${moment.bottom - moment.top}px`;
    line.style.transform = `translate(${canvas.offsetLeft + moment.place(head) - 0.5}px, ${canvas.offsetTop + moment.top}px)`;
  }
}

// ------------------------------------------------------------------------------------------------------------------ clock

const frames = { times: [], spent: [], count: 0 };

function frame(time) {
  const entered = performance.now();
  const passed = Math.min(time - (clock.last || time), 100) / 1000;
  clock.last = time;
  const { store, reader } = running;
  const newest = store.end - 1;
  const behind = newest < clock.wanted && running.sound; // the moment in view has not been computed yet
  if (clock.playing && !clock.dragged && !behind) {
    clock.head += (passed * clock.speed) / reader.interval;
    if (!perTurn && clock.head > wholeRun) clock.head = 0;
  }
  if (clock.head > newest && newest > 0 && clock.playing && !behind) clock.head = newest; // plays as fast as the worker computes
  if (clock.head < store.begin && !behind) clock.head = store.begin;
  const until = perTurn ? Math.ceil(clock.head + AHEAD * perTurn) : wholeRun + 1;
  running.ask(until);
  comparison?.ask(until);
  scene.look(running, 60);
  if (!clock.sized && scene.seen > 0.5 * wholeTurns) begun();
  // For half a second the last picture stays; after that, the picture shows the progress of the worker.
  const made = behind && time - clock.begun < 500 ? null : canvasFor($("scene"));
  if (made && store.end)
    scene.draw(made.pen, made.width, made.height, running, Math.min(clock.head, newest), comparison?.store.end ? comparison : null);
  drawStale(time);
  if (made) followMoment(Math.min(clock.head, newest));
  if (made || frames.count % 6 === 0) tellTime();
  frames.count += 1;
  frames.times.push(time);
  if (frames.times.length > 60) frames.times.shift();
  frames.spent.push(performance.now() - entered); // ms of drawing
  if (frames.spent.length > 240) frames.spent.shift();
  requestAnimationFrame(frame);
}

function tellTime() {
  const { store, reader } = running;
  const head = Math.max(0, clock.wanted < store.end ? Math.min(clock.head, store.end - 1) : clock.head);
  const time = head * reader.interval;
  $("time").textContent = perTurn
    ? `turn ${Math.floor(head / perTurn) + 1}, ${String(Math.round(withinTurn(reader.rotation(head / perTurn))) % 360).padStart(3)}°, ${quantity(time, "s", 5)}`
    : factors
      ? `load factor ${Number(factorAt(head).toPrecision(4))}`
      : `${quantity(time, "s", 5)}`;
  if (clock.wanted > 0 && store.end <= clock.wanted && running.sound)
    $("time").textContent = `stepping: ${Math.floor((100 * store.end) / clock.wanted)} %`;
  const scrub = $("scrub");
  scrub.min = store.begin;
  scrub.max = Math.max(store.end - 1, 1);
  if (!clock.dragged) scrub.value = head;
  const rate = (1000 * (frames.times.length - 1)) / (frames.times.at(-1) - frames.times[0] || 1);
  const perStep = running.steps ? (1000 * running.spent) / running.steps : 0;
  // Before the first step and the second frame there is no rate.
  const rates = `${rate.toFixed(0)} frames/s · ${perStep.toPrecision(2)} µs a step · ${quantity(reader.dt, "s")} steps`;
  if (!factors) $("rate").textContent = running.steps && rate > 0 ? rates : "";
}

function play(on = !clock.playing) {
  clock.playing = on;
  $("play-sign").setAttribute("d", on ? "M4 3h3v10H4zM9 3h3v10H9z" : "M4 2v12l10-6z");
  $("play").setAttribute("aria-label", on ? "pause" : "play");
  dirty(true);
}

// Pause and move by some outputs.
function step(by) {
  play(false);
  clock.wanted = 0;
  clock.head = Math.max(running.store.begin, Math.min(Math.round(clock.head) + by, Math.max(running.store.end - 1, 0)));
}

// Set the speed of play to 10 ** exponent times real time.
function setSpeed(exponent) {
  clock.speed = 10 ** exponent;
  $("speed").value = exponent;
  $("speed-text").textContent = exponent === 0 ? "real time" : `${Number((1 / clock.speed).toPrecision(2))}× slower`;
}

// When the extent of the motion is known: set the enlargement of clearances, and select a quantity that changes.
function begun() {
  if (factors) {
    const { body, quantity } = longestWay(running);
    select("body", body);
    select("quantity", quantity);
  }
  if (!factors) select("quantity", movingQuantity());
  fitScene();
  setMagnify(suitableMagnify());
}

// Exponent of the enlargement with which the largest clearance circle is `share` of the size of the motion.
function suitableMagnify(share = 0.022) {
  const size = Math.max(...[0, 1].map((axis) => scene.high[axis] - scene.low[axis]));
  const play = Math.max(0, ...given.contacts.map((contact, k) => (contact.kind === "bearing" ? running.reader.plays[k] : 0)));
  return play ? Math.min(3, Math.max(0, Math.log10((share * size) / play))) : 0;
}

// The selected quantity of the selected body if it changes, else the coordinate that changes most.
function movingQuantity() {
  const chosen = selected.quantity;
  const way = (quantity) => {
    selected.quantity = quantity;
    const { xs } = phaseOf(running, { first: running.store.begin, count: running.store.end - 1 - running.store.begin });
    return xs.reduce((a, b) => Math.max(a, b)) - xs.reduce((a, b) => Math.min(a, b));
  };
  const moves = way(chosen) >= 1e-6;
  const found = moves ? chosen : ["x", "y"].reduce((best, quantity) => (way(quantity) > way(best) ? quantity : best));
  selected.quantity = chosen;
  return found;
}

// The canvas is as high as the mechanism fills it, within what fits on the screen.
function fitScene() {
  const canvas = $("scene");
  const highest = Math.min(0.68 * window.innerHeight, 680);
  canvas.style.height = `${Math.round(Math.min(highest, Math.max(scene.heightAt(canvas.clientWidth), 200)))}px`;
}

function setMagnify(exponent) {
  clock.sized = true;
  scene.magnify = 10 ** exponent;
  $("magnify").value = exponent;
  $("magnify-text").textContent = `${Number(scene.magnify.toPrecision(2))}×`;
}

// ------------------------------------------------------------------------------------------------------------- comparison

function keep() {
  comparison ??= new Running();
  comparison.begin(sliders.setting, running.until);
  $("kept").textContent = `Kept: ${sliders.setting.words}`;
  $("comparison").hidden = false;
  dirty(true);
}

function drop() {
  comparison?.worker.terminate();
  comparison = null;
  $("comparison").hidden = true;
  dirty(true);
}

// --------------------------------------------------------------------------------------------------------------- controls

$("play").onclick = () => play();
$("back").onclick = () => step(-1);
$("forth").onclick = () => step(1);
$("speed").oninput = () => setSpeed(Number($("speed").value));
$("magnify").oninput = () => setMagnify(Number($("magnify").value));
$("scrub").oninput = () => {
  clock.dragged = true;
  clock.wanted = 0;
  clock.head = Number($("scrub").value);
  staleAt = Math.min(staleAt, performance.now() - 150);
};
$("scrub").onchange = () => {
  clock.dragged = false;
  dirty(true);
};
$("keep").onclick = keep;
$("drop").onclick = drop;
$("reset").onclick = () => sliders.take(new Setting());
$("theme").onclick = () => {
  setTheme(document.documentElement.dataset.theme === "dark" ? "light" : "dark");
  dirty(true);
};
for (const kind of Object.keys(scene.show)) {
  const box = $(`show-${kind}`);
  box.checked = scene.show[kind];
  box.onchange = () => {
    scene.show[kind] = box.checked;
  };
}
$("get-model").onclick = () => hand(fileName(".toml"), sliders.setting.model, "application/toml");
$("get-csv").onclick = () => hand(fileName(".csv"), csvOf(running), "text/csv");
$("get-png").onclick = () => handPng($("scene"), fileName(".png"));
$("get-svg").onclick = () => {
  const draw = (pen, width, height) => scene.draw(pen, width, height, running, clock.head, comparison);
  hand(fileName(".svg"), svgOf($("scene"), draw), "image/svg+xml");
};
$("help").onclick = () => $("keys").showModal();
$("keys-close").onclick = () => $("keys").close();

$("scene").onclick = (event) => {
  const box = $("scene").getBoundingClientRect();
  const found = scene.pick(event.clientX - box.left, event.clientY - box.top);
  if (found?.joint) select("joint", found.joint);
  else if (found?.pin) scene.traces.push(found.pin);
  else if (found) scene.traces.splice(found.trace, 1);
};

// Pinching, or the wheel with Ctrl, zooms about the pointer; a zoomed picture can be dragged; a double click shows all again.
$("scene").addEventListener(
  "wheel",
  (event) => {
    if (!event.ctrlKey && !event.metaKey) return;
    event.preventDefault();
    const box = $("scene").getBoundingClientRect();
    scene.zoomed(2 ** (-event.deltaY / 200), event.clientX - box.left - box.width / 2, event.clientY - box.top - box.height / 2);
  },
  { passive: false },
);
$("scene").onpointermove = (event) => {
  if (event.buttons === 1 && scene.zoom > 1) scene.moved(event.movementX, event.movementY);
};
$("scene").ondblclick = () => scene.zoomed(0);

const KEYS = {
  " ": () => play(),
  ArrowLeft: (event) => step(event.shiftKey ? -Math.round(wholeTurns / 36) : -1),
  ArrowRight: (event) => step(event.shiftKey ? Math.round(wholeTurns / 36) : 1),
  Home: () => step(Number.NEGATIVE_INFINITY),
  End: () => step(Number.POSITIVE_INFINITY),
  "[": () => setSpeed(Math.max(Number($("speed").value) - 0.25, -3)),
  "]": () => setSpeed(Math.min(Number($("speed").value) + 0.25, 0)),
  "-": () => setMagnify(Math.max(Number($("magnify").value) - 0.1, 0)),
  "+": () => setMagnify(Math.min(Number($("magnify").value) + 0.1, 3)),
  z: () => scene.zoomed(1.5),
  Z: () => scene.zoomed(1 / 1.5),
  j: () => select("joint", OPTIONS.joint()[(OPTIONS.joint().indexOf(selected.joint) + 1) % OPTIONS.joint().length]),
  k: () => (comparison ? drop() : keep()),
  r: () => sliders.take(new Setting()),
  t: () => $("theme").click(),
  "?": () => $("keys").showModal(),
};

// Whether the focused element handles the key itself.
function taken({ target, key }) {
  if (target.tagName === "SELECT") return true;
  if (target.tagName === "INPUT") return target.type === "checkbox" ? key === " " : /^(Arrow|Home|End|Page)/.test(key);
  return key === " " && ["BUTTON", "SUMMARY"].includes(target.tagName);
}

document.addEventListener("keydown", (event) => {
  if (taken(event) || event.ctrlKey || event.metaKey || event.altKey || !KEYS[event.key] || $("keys").open) return;
  event.preventDefault();
  KEYS[event.key](event);
});

window.addEventListener("resize", () => {
  if (clock.sized) fitScene();
  dirty(true);
});
window.addEventListener("beforeprint", () => {
  for (const card of cards) drawCard(card, true);
});
window.addEventListener("scroll", () => dirty(true), { passive: true });
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", (event) => {
  setTheme(event.matches ? "dark" : "light");
  dirty(true);
});

// ------------------------------------------------------------------------------------------------------------------ start

setTheme(matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light");
document.title = `${given.name}: running`;
$("name").textContent = given.name;
$("note").textContent = given.note;
for (const note of given.notes) $("notes").append(Object.assign(document.createElement("li"), { textContent: note }));
if (reducedMotion) play(false);
$("version").textContent = `vfife ${given.version}`;
if (factors) $("peaks-title").textContent = "Peaks, of all equilibria; errors not estimated";
$("panel").hidden = given.slides.length === 0;
$("speed-row").hidden = Boolean(factors);
$("magnify-row").hidden = !given.contacts.some((contact) => contact.kind === "bearing");
clock.wanted = clock.head;
running.begin(sliders.setting, firstUntil);
{
  const span = (perTurn ?? wholeRun) * running.reader.interval; // s; a turn lasts about 4 s, a run 10 s, at most real time
  setSpeed(Math.max(-3, Math.min(0, Math.round(4 * Math.log10(span / (perTurn ? 4 : 10))) / 4)));
}
requestAnimationFrame(frame);

// A page that embeds this one may set the sliders, as the report of a study does for a case: positions by slider name.
window.addEventListener("message", ({ data }) => {
  const asked = data?.positions;
  if (!asked || typeof asked !== "object") return;
  const whole = (k, slide) => Number.isInteger(k) && k >= 0 && k < slide.values.length;
  const positions = given.slides.map((slide, s) => (whole(asked[slide.name], slide) ? asked[slide.name] : sliders.setting.positions[s]));
  sliders.take(new Setting(positions));
});

// For view.js, shell.js and the browser's developer tools.
window.live = { running, scene, clock, sliders, selected, frames, cards, quantity };
