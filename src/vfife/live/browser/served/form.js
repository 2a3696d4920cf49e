// Form of a model's tables, generated from the JSON Schema of model files. Values are validated by Python, whose messages appear at
// the fields.

// Place of a value as it appears in faults: "[joint.C] clearance".
function placeOf(path) {
  const first = path.findIndex((part, k) => k > 0 && typeof part === "number");
  const last = first < 0 ? path.length : first;
  const inside = path.slice(last).map((part) => (typeof part === "number" ? `[${part}]` : `.${part}`));
  const table = last > 1 ? `[${path.slice(0, last - 1).join(".")}] ` : "";
  return `${table}${path[last - 1]}${inside.join("")}`;
}

const element = (kind, given = {}, ...inside) => {
  const made = Object.assign(document.createElement(kind), given);
  made.append(...inside);
  return made;
};
const isTable = (value) => typeof value === "object" && value !== null;

class Form {
  // `set(path, text)` changes a value; null removes it.
  constructor(place, schema, set) {
    Object.assign(this, { place, schema, set, rows: new Map(), open: new Set(["run"]), faults: [] });
  }

  // ---------------------------------------------------------------------------------------------------------- schema

  // Schema of a value: references are resolved, and of several alternatives the one with the fewest contradictions is chosen.
  of(schema, value) {
    const whole = schema?.allOf?.length === 1 ? { ...schema.allOf[0], description: schema.description } : schema;
    const named = whole?.$ref && this.schema.definitions[whole.$ref.split("/").at(-1)];
    const found = named ? { ...named, description: whole.description ?? named.description } : { ...whole };
    const kinds = found.oneOf ?? (found.anyOf?.some((schema) => schema.$ref || schema.properties) ? found.anyOf : null);
    if (!kinds) return found;
    const ways = kinds.map((kind) => this.of(kind, value)).flatMap((kind) => kind.ways ?? [kind]);
    const known = isTable(value) ? value : {};
    const apart = (way) => {
      if (!way.properties) return 50;
      let sum = (way.required ?? []).filter((key) => !(key in known)).length;
      for (const [key, said] of Object.entries(known)) {
        const property = way.properties[key];
        if (!property) sum += 10;
        else if (property.enum && !property.enum.includes(said)) sum += 100;
      }
      return sum;
    };
    const best = ways.reduce((best, way) => (apart(way) < apart(best) ? way : best), ways[0] ?? {});
    return { ...best, description: found.description ?? best.description, ways: ways.filter((way) => way.properties) };
  }

  // Values of a key that selects the kind, over all kinds.
  words(table, key) {
    const values = (table.ways ?? [table]).flatMap((way) => way.properties?.[key]?.enum ?? []);
    return [...new Set(values)];
  }

  // ------------------------------------------------------------------------------------------------------------ form

  show(values) {
    this.values = values;
    const focus = this.held();
    this.rows = new Map();
    const model = element(
      "section",
      {},
      this.table({ properties: this.schema.properties }, values, [], (key) => !this.inner(key)),
    );
    const parts = Object.keys(this.schema.properties).filter((key) => this.inner(key));
    this.place.replaceChildren(model, ...parts.map((key) => this.section(key, values[key])).filter(Boolean));
    this.hold(focus);
    this.tell(this.faults);
  }

  inner(key) {
    const schema = this.of(this.schema.properties[key], {});
    return Boolean(schema.properties || schema.additionalProperties);
  }

  // Tables of a section: one for `run` and `start`, one per name for the others.
  section(key, value) {
    const schema = this.of(this.schema.properties[key], value ?? {});
    if (schema.properties) return this.folded([key], key, schema, value ?? {});
    if (!isTable(value) || !Object.keys(value).length) return null;
    const title = element("h2", { textContent: key, title: schema.description ?? "" });
    if (!isTable(Object.values(value)[0])) {
      const rows = Object.entries(value).map(([name, entry]) => this.row(this.of(schema.additionalProperties, entry), [key, name], entry));
      return element("section", {}, title, ...rows);
    }
    const nouns = Object.entries(value).map(([name, entry]) => this.folded([key, name], name, this.of(schema.additionalProperties, entry), entry));
    return element("section", {}, title, ...nouns);
  }

  folded(path, title, schema, values) {
    const word = values.kind ?? values.model;
    const summary = element("summary", { title: schema.description ?? "" }, title, element("small", { textContent: word ? ` ${word}` : "" }));
    const made = element("details", { open: this.open.has(path.join(".")) }, summary);
    const fill = () => made.childElementCount === 1 && made.append(this.table(schema, values, path));
    if (made.open) fill();
    made.ontoggle = () => {
      this.open[made.open ? "add" : "delete"](path.join("."));
      if (made.open) fill();
    };
    made.fill = fill;
    made.dataset.table = path.join(".");
    return made;
  }

  // Keys of a table, then those that can be added.
  table(schema, values, path, wanted = () => true) {
    const made = element("div", { className: "table" });
    const known = Object.keys(schema.properties ?? {}).filter(wanted);
    const present = [...Object.keys(values).filter((key) => wanted(key) && !known.includes(key)), ...known.filter((key) => key in values)];
    const needed = known.filter((key) => !(key in values) && schema.required?.includes(key));
    made.append(...[...present, ...needed].map((key) => this.entry(schema, key, values[key], path)));
    const more = known.filter((key) => !(key in values) && !needed.includes(key));
    if (more.length) {
      const name = `${path.join(".")}+`;
      const optional = element(
        "details",
        { className: "more", open: this.open.has(name) },
        element("summary", { textContent: `${more.length} more` }),
      );
      const fill = () => optional.childElementCount === 1 && optional.append(...more.map((key) => this.entry(schema, key, undefined, path)));
      if (optional.open) fill();
      optional.ontoggle = () => {
        this.open[optional.open ? "add" : "delete"](name);
        if (optional.open) fill();
      };
      optional.fill = fill;
      made.append(optional);
    }
    return made;
  }

  // Row of a key and its value, or a nested table.
  entry(schema, key, value, path) {
    const of = this.of(schema.properties?.[key] ?? {}, value ?? {});
    const place = [...path, key];
    if (isTable(value)) {
      const inside = of.properties
        ? of
        : { properties: Object.fromEntries(Object.keys(value).map((name) => [name, of.additionalProperties ?? {}])) };
      return element("fieldset", {}, element("legend", { textContent: key, title: of.description ?? "" }), this.table(inside, value, place));
    }
    const laws = of.ways && this.words(of, "law");
    if (laws?.length) return this.row({ enum: laws, description: of.description }, [...place, "law"], undefined, key);
    const words = this.words(schema, key);
    return this.row(words.length ? { ...of, enum: words } : of, place, value);
  }

  row(schema, path, value, name = path.at(-1)) {
    const id = `field-${path.join(".")}`;
    const input = this.input(schema, value);
    Object.assign(input, { id, title: schema.description ?? "" });
    input.onchange = () => this.send(schema, path, input);
    const unit = schema["x-unit"] ?? schema.items?.[0]?.["x-unit"] ?? "";
    const label = element("label", { htmlFor: id, textContent: name, title: schema.description ?? "" });
    const fault = element("p", { className: "fault", id: `${id}-fault` });
    const made = element(
      "div",
      { className: "row" },
      label,
      input,
      element("span", { className: "unit", textContent: unit === "1" ? "" : unit }),
      fault,
    );
    this.rows.set(placeOf(path), { input, fault, path });
    return made;
  }

  input(schema, value) {
    const words = schema.enum ?? (schema.type === "boolean" ? ["true", "false"] : null);
    if (!words) {
      const text = value === undefined ? "" : String(value);
      const stands = schema.default === undefined || schema.default === "" ? "" : `${JSON.stringify(schema.default).replaceAll('"', "")}`;
      return element("input", { value: text, defaultValue: text, placeholder: stands, autocomplete: "off", spellcheck: false });
    }
    const list = element("select");
    const usual = schema.default === undefined ? "–" : `${schema.default} (default)`;
    if (value === undefined || !words.includes(String(value))) list.append(element("option", { value: "", textContent: usual }));
    list.append(...words.map((word) => element("option", { value: word, textContent: word })));
    list.value = value === undefined ? "" : String(value);
    return list;
  }

  async send(schema, path, input) {
    const typed = input.value.trim();
    const text = schema.type === "string" || (schema.enum && schema.type !== "boolean") ? JSON.stringify(typed) : typed;
    await this.set(path, typed === "" ? null : text);
  }

  // Field with the focus and its typed text, which a rebuilt form keeps.
  held() {
    const at = document.activeElement;
    if (!this.place.contains(at)) return null;
    const typed = at.defaultValue !== undefined && at.value !== at.defaultValue ? at.value : null;
    return { id: at.id, start: at.selectionStart, end: at.selectionEnd, typed };
  }

  hold(held) {
    const at = held?.id && document.getElementById(held.id);
    if (!at) return;
    at.focus();
    if (held.typed !== null && at.defaultValue !== undefined) at.value = held.typed;
    if (at.setSelectionRange && held.start !== null) at.setSelectionRange(held.start, held.end);
  }

  // ---------------------------------------------------------------------------------------------------------- faults

  // Show faults at the fields that they name, and return the others.
  tell(faults) {
    this.faults = faults;
    for (const { input, fault } of this.rows.values()) {
      input.removeAttribute("aria-invalid");
      input.removeAttribute("aria-describedby");
      fault.textContent = "";
    }
    return faults.filter(({ where, said }) => !this.tellOne(where, said));
  }

  tellOne(where, said) {
    if (!where) return false;
    for (const made of this.place.querySelectorAll("details[data-table]")) {
      const [table] = /(?<=^\[)[^\]]*/.exec(where) ?? [""];
      if (table === made.dataset.table || table.startsWith(`${made.dataset.table}.`)) {
        made.open = true;
        made.fill();
      }
    }
    const rows = [...this.rows].filter(([place]) => where === place || where.startsWith(`${place}[`) || where.startsWith(`${place}.`));
    const [, found] = rows.reduce((best, row) => (row[0].length > best[0].length ? row : best), ["", null]);
    if (!found) return false;
    const more = found.input.closest("details.more");
    if (more) more.open = true;
    found.fault.textContent = found.fault.textContent ? `${found.fault.textContent} ${said}` : said;
    found.input.setAttribute("aria-invalid", "true");
    found.input.setAttribute("aria-describedby", found.fault.id);
    return true;
  }
}
