// Sliders over the positions that Python assembled. Moving one restarts the mechanism with the numbers of the new setting.

// Label of a path: "joint.C.contact.restitution" becomes "contact restitution, joint C".
function friendly(name) {
  const [section, noun, ...words] = name.split(".");
  return words.length ? `${words.join(" ")}, ${section} ${noun}` : name;
}

const timesWords = (factor) => (factor === 1 ? "as in the model" : `${Number(factor.toPrecision(3))} times the model`);

// Positions of the slides at the factors of the model's values that all of them have; Python gives them the same factors to
// twelve digits.
function commonFactors(slides) {
  const positionAt = ({ values, here }, factor) => values.findIndex((value) => Math.abs(value / values[here] / factor - 1) < 1e-9);
  const [first] = slides;
  return first.values
    .map((value) => value / first.values[first.here])
    .map((factor) => ({ factor, positions: slides.map((slide) => positionAt(slide, factor)) }))
    .filter(({ factor, positions }) => factor > 0 && positions.every((position) => position >= 0));
}

class Sliders {
  constructor(place, changed) {
    this.setting = new Setting();
    this.changed = changed;
    this.inputs = given.slides.map((slide, s) => this.row(place, slide, s));
    this.clearances = given.slides.flatMap((slide, s) => (slide.paths.every((path) => path.endsWith(".clearance")) ? [s] : []));
    const apart = groups.every((group) => !group.singly || this.clearances.filter((s) => group.sliders.includes(s)).length < 2);
    this.all = this.clearances.length > 1 && apart ? this.allRow(place) : null;
  }

  // One slider for all clearances: its positions are the factors of the model's values that every clearance has.
  allRow(place) {
    this.common = commonFactors(this.clearances.map((s) => given.slides[s]));
    if (this.common.length < 2) return null;
    const factors = this.common.map(({ factor }) => factor);
    const slide = { name: "all clearances", paths: [], unit: "1", values: factors, here: factors.indexOf(1), labels: factors.map(timesWords) };
    const row = this.row(place, slide, "all", (position) => this.moveAll(this.common[position].positions));
    place.prepend(row.input.parentElement);
    return row;
  }

  moveAll(positions) {
    this.take(this.clearances.reduce((moved, s, k) => moved.with(s, positions[k]), this.setting));
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

  // Show the common factor of all clearances, or that they have none.
  tellAll() {
    const position = this.common.findIndex(({ positions }) => positions.every((at, k) => at === this.setting.positions[this.clearances[k]]));
    if (position >= 0) {
      this.tell(this.all, position);
      return;
    }
    const { input, output, back } = this.all;
    output.textContent = "no common factor";
    input.setAttribute("aria-valuetext", output.textContent);
    back.disabled = false;
  }

  take(setting) {
    this.setting = setting;
    this.inputs.forEach((slider, s) => {
      this.tell(slider, setting.positions[s]);
    });
    if (this.all) this.tellAll();
    this.changed(setting);
  }
}
