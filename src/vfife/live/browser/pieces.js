// Data of the page, and settings of its sliders. A setting is the vector of numbers that Python assembled for the model's own
// values, overwritten by the patch of each group of sliders; see live/page/patches.py for why patches combine.

const given = JSON.parse(document.getElementById("given").textContent);

// Little-endian doubles from base64.
function unpacked(text) {
  const bytes = Uint8Array.from(atob(text), (character) => character.charCodeAt(0));
  return new Float64Array(bytes.buffer);
}

const base = unpacked(given.vector);
const groups = given.groups.map((group) => ({ ...group, values: unpacked(group.values) }));

// Index of the first number of each part of the vector.
const partAt = {};
{
  let at = 0;
  for (const [name, length] of Object.entries(given.parts)) {
    partAt[name] = at;
    at += length;
  }
}

// Positions of all sliders, and the vector of numbers for them.
class Setting {
  constructor(positions = given.slides.map((slide) => slide.here)) {
    this.positions = positions;
    this.vector = base.slice();
    for (const group of groups) {
      const at = this.place(group) * group.rows.length;
      group.rows.forEach((row, k) => {
        this.vector[row] = group.values[at + k];
      });
    }
  }

  // Index of this setting among the combinations of a group; the last slider varies fastest.
  place(group) {
    if (group.singly) return this.alone(group);
    return group.sliders.reduce((at, s) => at * given.slides[s].values.length + this.positions[s], 0);
  }

  // The same for a group in which one slider moves at a time: the model's setting is first, then the other positions of each.
  alone({ sliders }) {
    let at = 1;
    for (const s of sliders) {
      const { here, values } = given.slides[s];
      if (this.positions[s] !== here) return at + this.positions[s] - (this.positions[s] > here ? 1 : 0);
      at += values.length - 1;
    }
    return 0;
  }

  // This setting with one slider moved; sliders that cannot be combined with it return to the model's value.
  with(slider, position) {
    const returned = groups.filter((group) => group.singly && group.sliders.includes(slider)).flatMap((group) => group.sliders);
    return new Setting(this.positions.map((old, s) => (s === slider ? position : returned.includes(s) ? given.slides[s].here : old)));
  }

  part(name) {
    return this.vector.subarray(partAt[name], partAt[name] + given.parts[name]);
  }

  get moved() {
    return given.slides.filter((slide, s) => this.positions[s] !== slide.here);
  }

  // Description of the sliders that differ from the model.
  get words() {
    const words = given.slides.map((slide, s) =>
      this.positions[s] === slide.here ? "" : `${friendly(slide.name)} ${shownValue(slide, this.positions[s])}`,
    );
    return words.filter(Boolean).join(", ") || "as in the model";
  }

  // Model file of this setting. If two sliders change the same line, the values are given as --set options in a comment instead.
  get model() {
    const lines = given.model.split("\n").slice(0, -1);
    const moved = given.slides.flatMap((slide, s) =>
      this.positions[s] === slide.here ? [] : slide.paths.map((path) => `${path}=${slide.values[this.positions[s]]}`),
    );
    if (!given.texts) return [...moved.map((change) => `# run with --set ${change}`), ...lines, ""].join("\n");
    for (const group of groups) for (const [line, text] of group.lines[this.place(group)]) lines[line] = text;
    return `${lines.filter((line) => line !== null).join("\n")}\n`;
  }
}

const VANISHING = 1e-18; // in SI units: rounding of what is nothing

// Number with a unit whose prefix suits its size.
// A `size` other than that of the value chooses the unit.
function quantity(value, unit, digits = 3, size = Math.abs(value)) {
  const text = (factor, name) => `${Number((value * factor).toPrecision(digits))}${name ? ` ${name}` : ""}`;
  if (!Number.isFinite(value)) return "–";
  if (unit === "1" || unit === "") return text(size < VANISHING ? 0 : 1, "");
  if (size < VANISHING) return text(0, unit);
  if (unit === "m") return size < 1e-4 && size > 0 ? text(1e6, "µm") : size < 1 ? text(1e3, "mm") : text(1, "m");
  if (unit === "s") return size < 1e-3 && size > 0 ? text(1e6, "µs") : size < 1 ? text(1e3, "ms") : text(1, "s");
  if (["N", "N m", "J", "W"].includes(unit)) {
    if (size >= 1e6) return text(1e-6, `M${unit}`);
    if (size >= 1e3) return text(1e-3, `k${unit}`);
    if (size < 0.1 && size > 0) return size < 1e-4 ? text(1e6, `µ${unit}`) : text(1e3, `m${unit}`);
  }
  return text(1, unit);
}

// Text for a position of a slider; angular velocities are also given in rpm.
function shownValue(slide, position) {
  if (slide.labels.length) return slide.labels[position];
  const value = slide.values[position];
  return slide.unit === "rad/s" ? `${quantity(value, "rad/s")} (${quantity((value * 30) / Math.PI, "rpm", 4)})` : quantity(value, slide.unit);
}
