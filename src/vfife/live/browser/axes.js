// Axes of a chart: ticks at round numbers, lines, bands, and a cursor.

// Nearest of 1, 2 and 5 times a power of ten.
function nice(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  const share = value / power;
  return power * (share < 1.5 ? 1 : share < 3.5 ? 2 : share < 7.5 ? 5 : 10);
}

const ANGLES = [15, 30, 45, 60, 90, 120, 180, 360];

class Axes {
  // `x` and `y` are { low, high, label }, with `log` for decades and `angle` for degrees; `legend` entries are [text, colour, dash, width].
  constructor(pen, width, height, x, y, legend = []) {
    Object.assign(this, { pen, x: { ...x }, y: { ...y } });
    if (!y.log && !y.exact) {
      const room = 0.06 * (this.y.high - this.y.low || 1);
      if (this.y.low !== 0) this.y.low -= room;
      this.y.high += room;
    }
    pen.font = `11px ${FONT}`;
    this.labels = this.ticks(this.y, height / 46).map((value) => [value, this.tickText(value, this.y)]);
    const widest = Math.max(10, ...this.labels.map(([, text]) => pen.measureText(text).width));
    this.box = { left: widest + 26, top: 8, right: width - 12, bottom: height - 34 };
    if (legend.length > 1) this.legend(legend);
    this.frame();
  }

  tickText(value, axis) {
    if (axis.log) return powerOfTen(Math.round(Math.log10(value)));
    const rounded = Number(value.toPrecision(6));
    return Math.abs(rounded) >= 1e5 || (rounded !== 0 && Math.abs(rounded) < 1e-3) ? rounded.toExponential() : String(rounded);
  }

  ticks(axis, most) {
    const { low, high } = axis;
    if (axis.log) {
      const [first, last] = [Math.ceil(Math.log10(low) - 1e-9), Math.floor(Math.log10(high) + 1e-9)];
      const stride = Math.max(1, Math.ceil((last - first) / Math.max(most, 2)));
      return Array.from({ length: Math.max(0, Math.floor((last - first) / stride) + 1) }, (_, k) => 10 ** (first + k * stride));
    }
    const span = high - low;
    if (!(span > 0)) return [low];
    const step = axis.angle ? (ANGLES.find((angle) => span / angle <= most) ?? 360 * Math.ceil(span / 360 / most)) : nice(span / Math.max(most, 2));
    const first = Math.ceil(low / step - 1e-9);
    return Array.from({ length: Math.floor(high / step + 1e-9) - first + 1 }, (_, k) => (first + k) * step);
  }

  across(value) {
    const { left, right } = this.box;
    return left + ((value - this.x.low) / (this.x.high - this.x.low || 1)) * (right - left);
  }

  up(value) {
    const { top, bottom } = this.box;
    const [a, b, v] = this.y.log ? [this.y.low, this.y.high, Math.max(value, 1e-300)].map(Math.log10) : [this.y.low, this.y.high, value];
    return bottom - ((v - a) / (b - a || 1)) * (bottom - top);
  }

  frame() {
    const { pen } = this;
    const { left, top, right, bottom } = this.box;
    pen.setLineDash([]);
    pen.lineWidth = 0.7;
    pen.strokeStyle = ink.faint;
    pen.fillStyle = ink.grey;
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    for (const [value, text] of this.labels) {
      const y = this.up(value);
      segment(pen, [left, y], [right, y]);
      pen.fillText(text, left - 5, y);
    }
    pen.textAlign = "center";
    pen.textBaseline = "top";
    for (const value of this.ticks(this.x, (right - left) / 62)) {
      const x = this.across(value);
      segment(pen, [x, top], [x, bottom]);
      pen.fillText(this.tickText(value, this.x), x, bottom + 4);
    }
    pen.fillStyle = ink.ink;
    pen.fillText(this.x.label, 0.5 * (left + right), bottom + 19);
    pen.save();
    pen.translate(11, 0.5 * (top + bottom));
    pen.rotate(-Math.PI / 2);
    pen.textBaseline = "middle";
    pen.fillText(this.y.label, 0, 0);
    pen.restore();
  }

  inside(draw) {
    const { pen } = this;
    const { left, top, right, bottom } = this.box;
    pen.save();
    pen.beginPath();
    pen.rect(left, top, right - left, bottom - top);
    pen.clip();
    draw();
    pen.restore();
  }

  // Line through (x, y); NaN interrupts it.
  line(across, up, { colour, width = 1.6, dash = [], alpha = 1 }) {
    const [xs, ys] = this.x.angle ? overTurn(across, up) : [across, up];
    this.inside(() => {
      const { pen } = this;
      pen.strokeStyle = colour;
      pen.lineWidth = width;
      pen.globalAlpha = alpha;
      pen.setLineDash(dash);
      pen.beginPath();
      let down = false;
      for (let k = 0; k < xs.length; k++) {
        const [x, y] = [this.across(xs[k]), this.up(ys[k])];
        if (!Number.isFinite(y)) down = false;
        else if (down) pen.lineTo(x, y);
        else {
          pen.moveTo(x, y);
          down = true;
        }
      }
      pen.stroke();
      pen.setLineDash([]);
      pen.globalAlpha = 1;
    });
  }

  band(across, lowest, highest, colour) {
    const [xs, lows] = this.x.angle ? overTurn(across, lowest) : [across, lowest];
    const highs = this.x.angle ? overTurn(across, highest)[1] : highest;
    const cut = lows.findIndex(Number.isNaN);
    if (cut >= 0) for (const part of [[0, cut], [cut + 1]]) this.area(...[xs, lows, highs].map((list) => list.slice(...part)), colour);
    else this.area(xs, lows, highs, colour);
  }

  area(xs, lows, highs, colour) {
    this.inside(() => {
      const { pen } = this;
      const points = [...xs.map((x, k) => [x, highs[k]]), ...xs.map((x, k) => [x, lows[k]]).reverse()];
      trail(
        pen,
        points.map(([x, y]) => [this.across(x), this.up(y)]),
        true,
      );
      pen.globalAlpha = 0.2;
      pen.fillStyle = colour;
      pen.fill();
      pen.globalAlpha = 1;
    });
  }

  cursor(at) {
    const x = this.x.angle ? withinTurn(at) : at;
    this.inside(() => {
      const { pen } = this;
      pen.strokeStyle = ink.ink;
      pen.lineWidth = 1;
      pen.globalAlpha = 0.65;
      segment(pen, [this.across(x), this.box.top], [this.across(x), this.box.bottom]);
      pen.globalAlpha = 1;
    });
  }

  // Return the map from outputs to the place of the moment (px). In the page a line above the chart follows it in every frame,
  // because charts are drawn more seldom; in a file the line of the moment `head` is drawn.
  follow(x, head) {
    if (Axes.forFile) this.cursor(x.of(head));
    const { top, bottom, left, right } = this.box;
    const place = (k) => Math.min(Math.max(this.across(this.x.angle ? withinTurn(x.of(k)) : x.of(k)), left), right);
    return { top, bottom, place };
  }

  dot(x, y, colour) {
    this.inside(() => disc(this.pen, [this.across(x), this.up(y)], 4, colour, ink.card));
  }

  // Draw the legend above the plot, in as many rows as needed.
  legend(entries) {
    const { pen, box } = this;
    let [x, y] = [box.left, 10];
    pen.textAlign = "left";
    pen.textBaseline = "middle";
    for (const [text, colour, dash = [], thick = 2] of entries) {
      const width = pen.measureText(text).width + 46;
      if (x > box.left && x + width > box.right + 14) [x, y] = [box.left, y + 16];
      pen.strokeStyle = colour;
      pen.lineWidth = thick;
      pen.globalAlpha = thick > 4 ? 0.25 : 1;
      pen.setLineDash(dash);
      segment(pen, [x, y], [x + 24, y]);
      pen.setLineDash([]);
      pen.globalAlpha = 1;
      pen.fillStyle = ink.ink;
      pen.fillText(text, x + 30, y);
      x += width;
    }
    box.top = y + 12;
  }
}

const RAISED = { "-": "⁻", 0: "⁰", 1: "¹", 2: "²", 3: "³", 4: "⁴", 5: "⁵", 6: "⁶", 7: "⁷", 8: "⁸", 9: "⁹" };
const powerOfTen = (power) => (power === 0 ? "1" : power === 1 ? "10" : `10${[...String(power)].map((digit) => RAISED[digit]).join("")}`);

// Factor and unit with a prefix that suits the largest of some numbers.
function scaleOf(largest, unit) {
  if (unit === "m") return largest < 1e-4 ? [1e6, "µm"] : largest < 1 ? [1e3, "mm"] : [1, "m"];
  if (unit === "s") return largest < 1e-3 ? [1e6, "µs"] : largest < 1 ? [1e3, "ms"] : [1, "s"];
  if (!["N", "N m", "J"].includes(unit)) return [1, unit];
  if (largest >= 2e6) return [1e-6, `M${unit}`];
  if (largest >= 2e3) return [1e-3, `k${unit}`];
  return largest < 0.5 && largest > 0 ? (largest < 5e-4 ? [1e6, `µ${unit}`] : [1e3, `m${unit}`]) : [1, unit];
}
