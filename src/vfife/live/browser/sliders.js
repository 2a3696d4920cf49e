// Sliders over the positions that Python assembled. Moving one restarts the mechanism with the numbers of the new setting.

// Label of a path: "joint.C.contact.restitution" becomes "contact restitution, joint C".
function friendly(name) {
  const [section, noun, ...words] = name.split(".");
  return words.length ? `${words.join(" ")}, ${section} ${noun}` : name;
}

const timesWords = (factor) => (factor === 1 ? "as in the model" : `${Number(factor.toPrecision(2))} times the model`);

class Sliders {
  constructor(place, changed) {
    this.setting = new Setting();
    this.changed = changed;
    this.inputs = given.slides.map((slide, s) => this.row(place, slide, s));
    this.clearances = given.slides.flatMap((slide, s) => (slide.paths.every((path) => path.endsWith(".clearance")) ? [s] : []));
    const apart = groups.every((group) => !group.singly || this.clearances.filter((s) => group.sliders.includes(s)).length < 2);
    this.all = this.clearances.length > 1 && apart ? this.allRow(place) : null;
  }

  // One slider for all clearances: its positions are factors of the model's values, those of the widest slider.
  allRow(place) {
    const shares = this.clearances.map((s) => given.slides[s]).map(({ values, here }) => values.map((value) => value / values[here]));
    const factors = shares.reduce((best, list) => (list.at(-1) > best.at(-1) ? list : best));
    const slide = { name: "all clearances", paths: [], unit: "1", values: factors, here: factors.indexOf(1), labels: factors.map(timesWords) };
    const row = this.row(place, slide, "all", (position) => this.moveAll(factors[position]));
    place.prepend(row.input.parentElement);
    return row;
  }

  // Move each clearance to its position nearest to a multiple of the model's value.
  moveAll(factor) {
    const setting = this.clearances.reduce((moved, s) => {
      const { values, here } = given.slides[s];
      const away = values.map((value) => Math.abs(value - factor * values[here]));
      return moved.with(s, away.indexOf(Math.min(...away)));
    }, this.setting);
    this.take(setting);
  }

  row(place, slide, s, moved = (position) => this.move(s, position)) {
    const row = document.createElement("div");
    row.className = "slide";
    const label = document.createElement("label");
    label.textContent = friendly(slide.name);
    label.title = slide.paths.join(", ");
    label.htmlFor = `slide-${s}`;
    const input = document.createElement("input");
    Object.assign(input, { type: "range", id: `slide-${s}`, min: 0, max: slide.values.length - 1, step: 1, value: slide.here });
    const output = document.createElement("output");
    output.htmlFor = input.id;
    const back = document.createElement("button");
    Object.assign(back, { type: "button", className: "small", textContent: "↺", title: "as in the model" });
    back.setAttribute("aria-label", `${slide.name} as in the model`);
    back.onclick = () => moved(slide.here);
    input.oninput = () => moved(Number(input.value));
    row.append(label, output, input, back);
    place.append(row);
    const slider = { input, output, back, slide };
    this.tell(slider, slide.here);
    return slider;
  }

  tell({ input, output, back, slide }, position) {
    const text = shownValue(slide, position);
    output.textContent = text;
    input.value = position;
    input.setAttribute("aria-valuetext", text);
    back.disabled = position === slide.here;
  }

  move(s, position) {
    if (this.setting.positions[s] === position) return;
    this.take(this.setting.with(s, position));
  }

  // Position of the slider for all clearances: the factor nearest to that of the clearance that differs most from the model.
  sharedPosition() {
    const { values } = this.all.slide;
    const logarithms = this.clearances.map((s) => {
      const slide = given.slides[s];
      return Math.log(slide.values[this.setting.positions[s]] / slide.values[slide.here]);
    });
    const largest = logarithms.reduce((a, b) => (Math.abs(b) > Math.abs(a) ? b : a));
    const away = values.map((value) => Math.abs(Math.log(value) - largest));
    return away.indexOf(Math.min(...away));
  }

  take(setting) {
    this.setting = setting;
    this.inputs.forEach((slider, s) => {
      this.tell(slider, setting.positions[s]);
    });
    if (this.all) this.tell(this.all, this.sharedPosition());
    this.changed(setting);
  }
}
