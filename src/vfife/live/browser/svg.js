// Subset of the canvas API that writes SVG, so that the same functions draw on the screen and export pictures.

class SvgPen {
  constructor(width, height) {
    Object.assign(this, { width, height, parts: [], clips: 0, stack: [], path: "", dash: [], groups: 0 });
    Object.assign(this, { strokeStyle: "#000", fillStyle: "#000", lineWidth: 1, globalAlpha: 1, lineCap: "butt", lineJoin: "miter" });
    Object.assign(this, { font: "12px sans-serif", textAlign: "left", textBaseline: "alphabetic" });
    this.measure = document.createElement("canvas").getContext("2d");
  }

  save() {
    const { strokeStyle, fillStyle, lineWidth, globalAlpha, lineCap, lineJoin, font, textAlign, textBaseline, dash, groups } = this;
    this.stack.push({ strokeStyle, fillStyle, lineWidth, globalAlpha, lineCap, lineJoin, font, textAlign, textBaseline, dash, groups });
  }

  restore() {
    const state = this.stack.pop();
    while (this.groups > state.groups) {
      this.parts.push("</g>");
      this.groups -= 1;
    }
    Object.assign(this, state);
  }

  group(attributes) {
    this.parts.push(`<g ${attributes}>`);
    this.groups += 1;
  }

  translate(x, y) {
    this.group(`transform="translate(${round(x)} ${round(y)})"`);
  }

  rotate(angle) {
    this.group(`transform="rotate(${round((angle * 180) / Math.PI)})"`);
  }

  beginPath() {
    this.path = "";
  }

  moveTo(x, y) {
    this.path += `M${round(x)} ${round(y)}`;
  }

  lineTo(x, y) {
    this.path += `${this.path ? "L" : "M"}${round(x)} ${round(y)}`;
  }

  closePath() {
    this.path += "Z";
  }

  rect(x, y, w, h) {
    this.path += `M${round(x)} ${round(y)}h${round(w)}v${round(h)}h${round(-w)}Z`;
  }

  arc(x, y, r, from, to) {
    const [a, b] = [from, to].map((angle) => `${round(x + r * Math.cos(angle))} ${round(y + r * Math.sin(angle))}`);
    if (Math.abs(to - from) > 6.28) {
      this.path += `M${round(x - r)} ${round(y)}a${round(r)} ${round(r)} 0 1 0 ${round(2 * r)} 0a${round(r)} ${round(r)} 0 1 0 ${round(-2 * r)} 0Z`;
    } else {
      this.path += `M${a}A${round(r)} ${round(r)} 0 ${Math.abs(to - from) > Math.PI ? 1 : 0} ${to > from ? 1 : 0} ${b}`;
    }
  }

  setLineDash(dash) {
    this.dash = dash;
  }

  clip() {
    this.clips += 1;
    this.parts.push(`<clipPath id="clip${this.clips}"><path d="${this.path}"/></clipPath>`);
    this.group(`clip-path="url(#clip${this.clips})"`);
  }

  stroke() {
    const dash = this.dash.length ? ` stroke-dasharray="${this.dash.join(" ")}"` : "";
    const caps = ` stroke-linecap="${this.lineCap}" stroke-linejoin="${this.lineJoin}"`;
    const look = `fill="none" stroke="${this.strokeStyle}" stroke-width="${this.lineWidth}" opacity="${this.globalAlpha}"`;
    if (this.path) this.parts.push(`<path d="${this.path}" ${look}${caps}${dash}/>`);
  }

  fill() {
    if (this.path) this.parts.push(`<path d="${this.path}" fill="${this.fillStyle}" opacity="${this.globalAlpha}"/>`);
  }

  fillRect(x, y, w, h) {
    this.parts.push(`<rect x="${round(x)}" y="${round(y)}" width="${round(w)}" height="${round(h)}" fill="${this.fillStyle}"/>`);
  }

  clearRect() {}

  measureText(text) {
    this.measure.font = this.font;
    return this.measure.measureText(text);
  }

  strokeText(text, x, y) {
    this.text(text, x, y, `fill="none" stroke="${this.strokeStyle}" stroke-width="${this.lineWidth}" stroke-linejoin="round"`);
  }

  fillText(text, x, y) {
    this.text(text, x, y, `fill="${this.fillStyle}"`);
  }

  text(text, x, y, look) {
    const anchor = { left: "start", center: "middle", right: "end" }[this.textAlign] ?? "start";
    const down = { middle: "0.35em", top: "0.8em" }[this.textBaseline] ?? "0";
    const [, weight, size] = this.font.match(/^(bold |600 )?(\d+(?:\.\d+)?)px/) ?? [null, "", "12"];
    const style = `font-family="sans-serif" font-size="${size}" font-weight="${weight ? 600 : 400}"`;
    this.parts.push(`<text x="${round(x)}" y="${round(y)}" dy="${down}" text-anchor="${anchor}" ${style} ${look}>${escaped(text)}</text>`);
  }

  get document() {
    const head = `<svg xmlns="http://www.w3.org/2000/svg" width="${this.width}" height="${this.height}" viewBox="0 0 ${this.width} ${this.height}">`;
    return `<?xml version="1.0" encoding="UTF-8"?>\n${head}\n${this.parts.join("\n")}\n</svg>\n`;
  }
}

const round = (value) => Math.round(value * 100) / 100;
const escaped = (text) => String(text).replace(/[&<>"']/g, (character) => `&#${character.codePointAt(0)};`);
