// Sliders over the positions that Python assembled. Moving one restarts the mechanism with the numbers of the new setting.

// Label of a path: "joint.C.contact.restitution" becomes "contact restitution, joint C".
function friendly(name) {
  const [section, noun, ...words] = name.split(".");
  return words.length ? `${words.join(" ")}, ${section} ${noun}` : name;
}

class Sliders {
  constructor(place, changed) {
    this.setting = new Setting();
    this.changed = changed;
    this.inputs = given.slides.map((slide, s) => this.row(place, slide, s));
  }

  row(place, slide, s) {
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
    back.onclick = () => this.move(s, slide.here);
    input.oninput = () => this.move(s, Number(input.value));
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

  take(setting) {
    this.setting = setting;
    this.inputs.forEach((slider, s) => {
      this.tell(slider, setting.positions[s]);
    });
    this.changed(setting);
  }
}
