// The editor around the page that runs a model: choice of the model, form and text, file, runs.
//
// Protocol: requests return the state of the document, or { faults } with status 404 (not open), 409 (changed meanwhile)
// or 422 (invalid). A request that changes a document sends the version that it was made from. Events arrive for every
// change of any document, from whichever browser or program; they contain the same state, so their order does not matter.

const $ = (id) => document.getElementById(id);
const session = { pending: [], model: null, frame: null, next: null, full: 0, typed: 0, measured: null, run: null };

// ----------------------------------------------------------------------------------------------------------------- asking

async function ask(where, sent) {
  const options = sent === undefined ? {} : { method: "POST", headers: { "content-type": "application/json" }, body: JSON.stringify(sent) };
  try {
    const answer = await fetch(where, options);
    if (answer.status === 403) return { ok: false, faults: [{ where: "", said: await answer.text() }] };
    const said = await answer.json();
    return answer.ok ? { ok: true, said } : { ok: false, status: answer.status, ...said };
  } catch {
    return { ok: false, faults: [{ where: "", said: "Python does not answer; was vfife live ended?" }] };
  }
}

const at = (what) => `model/${session.model.id}/${what}`;

function message(text) {
  $("message").textContent = text;
  $("message").hidden = !text;
}

function state(text) {
  $("state").textContent = $("state").title = text;
}

// ------------------------------------------------------------------------------------------------------------------ model

let form = null;

async function show(model, by = "") {
  const switched = session.model?.id !== model.id;
  if (!switched && model.version < session.model.version) return; // an answer or event that a newer one has overtaken
  const newer = switched || model.version !== session.model.version;
  if (newer || !session.shown) Object.assign(session, { pending: [], unsound: false });
  session.model = model;
  if (switched) {
    history.replaceState(null, "", `#${model.id}`);
    document.title = `${model.title}: vfife live`;
    session.full = 0;
    message("");
  }
  $("acts").hidden = false;
  $("gallery").hidden = true;
  $("gallery").replaceChildren(); // cancels requests for its drawings
  $("stage").hidden = drawn();
  $("sketch").hidden = !drawn();
  $("undo").disabled = model.undo === 0;
  $("redo").disabled = model.redo === 0;
  $("save").disabled = model.saved;
  $("save").textContent = model.file ? "Save" : "Save as …";
  $("run").textContent = model.saved ? "Run" : "Save and run";
  if (newer && drawn()) session.unloaded = true;
  else if (newer) load(switched); // first, because the server works on it while the form is filled
  if (newer) Object.assign(session, { draft: null, drafts: [] });
  if (newer && drawn() && sketch.base !== model.text) sketch.show(model.text, switched);
  choose();
  tellState();
  await fill();
  tell(model.faults, by === "file" ? `${model.file} has faults now; what runs is the model as it was before.` : "");
  untyped();
}

function tellState() {
  const { model } = session;
  const file = model.file ? `${model.file}${model.saved ? ", saved" : ", not saved"}` : "no file yet";
  state(session.full === model.version || !session.waits || drawn() ? file : `${file}; sliders are being assembled`);
}

async function fill() {
  if ($("panel").hidden) return;
  form ??= new Form($("fields"), (await ask("schema")).said, set);
  if (session.shown !== `${session.model.id} ${session.model.version}`) {
    form.faults = [];
    form.show(session.model.values);
    untyped();
  }
  session.shown = `${session.model.id} ${session.model.version}`;
}

// Show the text of the model, unless the text being typed is not valid yet.
function untyped() {
  if (session.pending.length || session.unsound || session.draft || document.activeElement === $("text")) return;
  if ($("text").value !== session.model.text) $("text").value = session.model.text;
  session.sent = session.model.text;
}

// Show faults at the fields that they name and the others above; changes that wait are listed and can be dropped.
function tell(faults, before = "") {
  session.faults = faults;
  const left = form && !$("panel").hidden && !$("fields").hidden ? form.tell(faults) : faults;
  if ($("fields").hidden && form) form.faults = faults;
  const said = [...(before && faults.length ? [before] : []), ...left.map((fault) => fault.said)];
  const lines = said.map((text) => element("li", { textContent: text }));
  if (session.pending.length) {
    const drop = element("button", { type: "button", className: "small", textContent: "Drop" });
    drop.onclick = () => {
      session.shown = null;
      show(session.model);
    };
    const waiting = session.pending.length > 1 ? `${session.pending.length} changes wait` : "This change waits";
    lines.unshift(element("li", { textContent: `${waiting} until the model is sound; what runs is the model before. ` }, drop));
  }
  $("faults").replaceChildren(...lines);
  if ($("panel").hidden) message(said.join(" "));
}

async function changed(answer) {
  if (answer.ok) {
    message("");
    await show(answer.said);
    return true;
  }
  if (answer.status === 409) {
    const { ok, said } = await ask(`model/${session.model.id}`);
    if (ok) await show(said);
  }
  tell(answer.faults);
  if (answer.status !== 422) message(answer.faults.map((fault) => fault.said).join(" "));
  return false;
}

// Send a value of the form. One that alone gives no valid model, such as a law without its parameters, waits and is sent
// again together with the next change.
async function set(path, value) {
  session.measured = performance.now();
  const key = JSON.stringify(path);
  const pending = [...session.pending.filter((change) => JSON.stringify(change.path) !== key), { path, value }];
  const answer = await ask(at("set"), { changes: pending, version: session.model.version });
  if (answer.draft) {
    session.pending = pending;
    form.show(answer.draft.values);
    $("text").value = answer.draft.text;
    session.sent = answer.draft.text;
  } else if (answer.ok) session.pending = [];
  return changed(answer);
}

async function type() {
  const text = $("text").value;
  if (text === session.sent) return;
  session.sent = text;
  session.measured = performance.now();
  const answer = await ask(at("text"), { text, version: session.model.version });
  session.unsound = !answer.ok;
  if ($("text").value === text) await changed(answer);
}

// ------------------------------------------------------------------------------------------------------------------- page

// Load the next page behind the visible one, which it replaces as soon as its mechanism moves: the view never goes blank.
function load(switched = false, sliders = false) {
  session.next?.remove();
  const { model } = session;
  const frame = element("iframe", { title: "the mechanism running", className: "behind" });
  frame.src = `${at("page")}?version=${model.version}${sliders ? "&sliders=1" : ""}`;
  session.next = frame;
  session.waits = true;
  $("stage").append(frame);
  const view = switched ? null : session.frame?.contentWindow?.live?.viewState?.();
  let taken = false;
  const look = () => {
    if (session.next !== frame) return;
    const inside = frame.contentWindow;
    if (inside?.document.body?.dataset.said) return refused(frame, inside.document.body.textContent);
    const live = inside?.live;
    if (live?.restoreView && view && !taken) {
      taken = true;
      live.restoreView({ ...view, moved: { ...(session.moved ?? {}), ...view.moved } });
    }
    // A page that only adds sliders waits until it has stepped to the moment in view; a changed model shows its start.
    const ready = live?.restoreView && live.running.store.end > (sliders ? live.clock.wanted : 1) && live.frames.count > 1;
    if (ready || (live?.restoreView && !live.running.sound)) seen(frame, sliders, view);
    else requestAnimationFrame(look);
  };
  requestAnimationFrame(look);
}

function seen(frame, sliders, view) {
  session.frame?.remove();
  session.frame = frame;
  session.next = null;
  session.moved = sliders ? null : { ...(session.moved ?? {}), ...(view?.moved ?? {}) };
  frame.className = "";
  if (session.measured !== null) session.took = performance.now() - session.measured;
  session.measured = null;
  if (sliders) session.full = session.model.version;
  tellState();
  const root = frame.contentDocument.documentElement;
  const follow = () => setTheme(root.dataset.theme);
  new MutationObserver(follow).observe(root, { attributes: true });
  follow();
  root.addEventListener("keydown", keys);
}

function refused(frame, said) {
  frame.remove();
  session.next = null;
  session.waits = false;
  if (session.frame && !session.frame.contentWindow?.location.pathname.includes(`/${session.model.id}/`)) {
    session.frame.remove();
    session.frame = null;
  }
  tellState();
  message(said);
}

// ------------------------------------------------------------------------------------------------------- what can be seen

let shelf = null;

async function stock() {
  const answer = await ask("shelf");
  if (!answer.ok) return message(answer.faults[0].said);
  shelf = answer.said;
  $("folder").textContent = shelf.folder;
  choose();
}

function choose() {
  if (!shelf) return;
  const group = (label, entries) =>
    entries.length && element("optgroup", { label }, ...entries.map(([value, text]) => element("option", { value, textContent: text })));
  const files = shelf.files.map(({ name }) => [`file:${name}`, name]);
  const gallery = shelf.gallery.map((model) => [`gallery:${model.name}`, model.title]);
  const texts = shelf.texts.map((model) => [`id:${model.id}`, model.name]);
  const groups = [group("Opened", texts), group(`Folder ${shelf.folder}`, files), group("Gallery", gallery)].filter(Boolean);
  $("choice").replaceChildren(element("option", { value: "", textContent: "Gallery …" }), ...groups);
  const { model } = session;
  if (!model) return;
  const value = model.file ? `file:${model.file}` : model.id.startsWith("gallery-") ? `gallery:${model.id.slice(8)}` : `id:${model.id}`;
  if (![...$("choice").options].some((option) => option.value === value)) $("choice").append(element("option", { value, textContent: model.name }));
  $("choice").value = value;
}

function showGallery() {
  if (!shelf) return;
  session.model = null;
  session.next?.remove();
  session.frame?.remove();
  Object.assign(session, { frame: null, next: null });
  history.replaceState(null, "", location.pathname);
  document.title = "vfife live";
  $("stage").hidden = $("sketch").hidden = $("acts").hidden = $("panel").hidden = true;
  $("edit").setAttribute("aria-expanded", "false");
  state("");
  const cards = (title, entries) =>
    entries.length ? [element("h2", { textContent: title }), element("div", { className: "cards" }, ...entries)] : [];
  const card = (asked, title, note, picture) => {
    const made = element(
      "button",
      { type: "button", className: "card" },
      element("b", { textContent: title }),
      element("span", { textContent: note }),
    );
    if (picture)
      made.prepend(
        element("img", { src: `drawing/${encodeURIComponent(picture)}`, alt: "", loading: "lazy", onerror: (event) => event.target.remove() }),
      );
    made.onclick = () => open(asked);
    return made;
  };
  const files = shelf.files.map(({ name, title }) => card({ file: name }, name, title, name));
  const shown = shelf.gallery.map((model) =>
    card({ gallery: model.name }, model.title, model.note || (model.static ? "equilibria" : ""), model.name),
  );
  const fresh = element("button", { type: "button", id: "new", textContent: "New", title: "draw a mechanism, from a driven crank" });
  fresh.onclick = begin;
  $("gallery").replaceChildren(fresh, ...cards(`Models of the folder ${shelf.folder}`, files), ...cards("Gallery", shown));
  $("gallery").hidden = false;
  choose();
}

async function open(asked) {
  session.measured = performance.now();
  const answer = await ask("open", asked);
  if (!answer.ok) return message(answer.faults.map((fault) => fault.said).join(" "));
  await show(answer.said);
  stock();
}

async function opened() {
  const id = decodeURIComponent(location.hash.slice(1));
  const answer =
    id && (await ask(id.startsWith("gallery-") ? "open" : `model/${id}`, id.startsWith("gallery-") ? { gallery: id.slice(8) } : undefined));
  await stock();
  if (answer?.ok) await show(answer.said);
  else showGallery();
}

// ------------------------------------------------------------------------------------------------------------ file and run

function naming() {
  const { model } = session;
  $("name").value = model.name.endsWith(".toml") ? model.name : `${model.name.replaceAll("_", "-")}.toml`;
  $("naming").returnValue = "";
  $("naming").showModal();
  $("name").select();
  return new Promise((done) => {
    $("naming").onclose = () => done($("naming").returnValue === "save" ? $("name").value.trim() : null);
  });
}

async function save() {
  if (session.draft) message("The drawing is a draft that does not close. Move a point until it does, or take it back with Undo; then save.");
  if (session.draft) return false;
  if (!session.model || session.model.saved) return session.model?.saved ?? false;
  const name = session.model.file ? undefined : await naming();
  if (name === null) return false;
  const good = await changed(await ask(at("save"), { name }));
  if (good) stock();
  return good;
}

async function run() {
  if (!(await save())) return;
  const answer = await ask(at("run"), {});
  if (!answer.ok) return changed(answer);
  session.run = session.model.id;
  $("told-title").textContent = `Running ${session.model.file}`;
  $("told-text").textContent = "With companions, as vfife run does. Progress appears here every ten seconds.";
  $("stop").hidden = false;
  $("told").showModal();
}

// ------------------------------------------------------------------------------------------------------------- what happens

const HEARD = {
  model: (event) => session.model?.id === event.id && show(event, event.by),
  gone: (event) => {
    if (session.model?.id !== event.id) return;
    message(event.said);
    ask(`model/${event.id}`).then(({ ok, said }) => ok && show(said));
  },
  sliders: (event) => {
    if (session.model?.id !== event.id || session.model.version !== event.version || session.full === event.version) return;
    session.full = event.version;
    tellState();
    if (event.said) state(event.said);
    else if (event.said === undefined) load(false, true);
  },
  end: () => {
    source.close();
    state("vfife live has been ended");
  },
  progress: (event) => {
    if (session.run === event.id) $("told-text").textContent = event.said;
  },
  run: (event) => {
    if (session.run !== event.id) return;
    $("told-title").textContent = event.code ? "The run failed" : "The run is done";
    $("told-text").textContent = event.said;
    $("stop").hidden = true;
  },
};

const source = new EventSource("events");
source.onmessage = ({ data }) => {
  const event = JSON.parse(data);
  HEARD[event.kind]?.(event);
};
source.onerror = () => state("Python does not answer");
source.onopen = () => {
  if (session.model) ask(`model/${session.model.id}`).then(({ ok, said }) => ok && show(said));
};

// --------------------------------------------------------------------------------------------------------------- controls

async function edit(on = $("panel").hidden) {
  $("panel").hidden = !on;
  $("edit").setAttribute("aria-expanded", String(on));
  if (!on || !session.model) return;
  await fill();
  untyped();
  tell(session.model.faults);
}

function tab(name) {
  for (const side of ["fields", "text"]) $(`tab-${side}`).setAttribute("aria-selected", String(side === name));
  $("fields").hidden = name !== "fields";
  $("text-side").hidden = name !== "text";
  untyped();
  tell(session.faults ?? []);
}

function keys(event) {
  if (!(event.ctrlKey || event.metaKey) || !session.model) return;
  const typing = ["INPUT", "TEXTAREA"].includes(event.target.tagName);
  if (event.key === "s") save();
  else if (event.key === "e") edit();
  else if (event.key === "d") draw();
  else if (event.key.toLowerCase() === "z" && drawn() && !typing) undo(event.shiftKey ? "redo" : "undo");
  else return;
  event.preventDefault();
}

document.addEventListener("keydown", keys);
$("edit").onclick = () => edit();
$("tab-fields").onclick = () => tab("fields");
$("tab-text").onclick = () => tab("text");
$("text").oninput = () => {
  clearTimeout(session.typed);
  session.typed = setTimeout(type, 350);
};
$("save").onclick = save;
$("run").onclick = run;
$("stop").onclick = () => ask(at("stop"), {});
$("told-close").onclick = () => $("told").close();
$("open").onclick = () => $("file").click();
$("file").onchange = async () => {
  const [file] = $("file").files;
  if (file) await open({ name: file.name, text: await file.text() });
  $("file").value = "";
};
$("choice").onchange = () => {
  const [kind, ...parts] = $("choice").value.split(":");
  const name = parts.join(":");
  if (kind === "id") ask(`model/${name}`).then(({ ok, said }) => ok && show(said));
  else if (name) open({ [kind]: name });
  else showGallery();
};
window.addEventListener("hashchange", opened);
setTheme(matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light");
