// Names of points and bodies on the paper, each at the first of several places where no other name and no sign is in its way.

const ROOM = 3; // pixels around a text

class Labels {
  constructor(paper) {
    Object.assign(this, { paper, boxes: [] });
  }

  draw(pen) {
    const { drawing, view } = this.paper;
    this.boxes = drawing.knots.map(({ pins, at }) => {
      const [x, y] = view.to(at);
      return grounded(pins) ? [x - 15, y - 8, x + 15, y + 22] : [x - 8, y - 8, x + 8, y + 8];
    });
    for (const knot of drawing.knots) this.knot(pen, knot);
    for (const body of drawing.bodies) this.body(pen, body);
  }

  knot(pen, knot) {
    const names = knot.joints.length ? knot.joints : knot.pins.map((pin) => split(pin)[1]);
    const [x, y] = this.paper.view.to(knot.at);
    const guided = this.paper.drawing.joints.some(({ name, guide }) => guide && knot.joints.includes(name));
    const far = guided ? 26 : 15; // outside of the lines of a guide
    const places = this.angles(knot).map((angle) => [x + far * Math.cos(angle), y - far * Math.sin(angle), Math.cos(angle) < 0 ? "right" : "left"]);
    this.write(pen, names.join(", "), places, ink.ink);
  }

  // Directions from a point, of eight the one farthest from all links and signs first.
  angles({ pins, at }) {
    const { drawing } = this.paper;
    const ends = pins.flatMap((pin) => {
      const k = drawing.index.get(split(pin)[0]);
      const places = k === undefined ? [] : drawing.bodies[k].outline.map((point) => drawing.inBody(k, point));
      return places.filter((place) => away(place, at) > 1e-6 * drawing.size);
    });
    const taken = [...ends.map((place) => Math.atan2(place[1] - at[1], place[0] - at[0])), ...(grounded(pins) ? [-1.1, -1.57, -2.04] : [])];
    const gap = (angle) =>
      Math.min(1.2, ...taken.map((direction) => Math.abs(Math.atan2(Math.sin(angle - direction), Math.cos(angle - direction)))));
    const angles = [1, 3, -1, -3, 0.4, 3.6, -0.4, -3.6].map((part) => (part * Math.PI) / 4);
    return angles.sort((a, b) => Math.round(20 * (gap(b) - gap(a)))); // angles of about the same gap keep their order
  }

  // Name of a body and, of a link, its length: beside its middle, or farther along.
  body(pen, body) {
    const { drawing, view } = this.paper;
    const k = drawing.index.get(body.name);
    const colour = this.paper.colour(k);
    if (!body.length) {
      const points = body.outline.map((point) => view.to(drawing.inBody(k, point)));
      const [x, y] = [0, 1].map((axis) => points.reduce((sum, point) => sum + point[axis], 0) / (points.length || 1));
      const lower = [x, y + 22, "center"];
      return this.write(pen, body.name, points.length > 2 ? [[x, y, "center"], lower] : [lower, [x, y - 22, "center"]], colour);
    }
    const angle = drawing.poses[0][k][2];
    const lower = Math.cos(angle) < 0 ? -1 : 1; // the lower side of the link, or the right one of an upright link
    const places = [lower, -lower].flatMap((side) =>
      [0.5, 0.7, 0.3].map((share) => {
        const [x, y] = view.to(drawing.inBody(k, [share * body.length, 0]));
        const [dx, dy] = [16 * side * Math.sin(angle), 16 * side * Math.cos(angle)];
        return [x + dx, y + dy, Math.abs(Math.sin(angle)) < 0.35 ? "center" : dx > 0 ? "left" : "right"];
      }),
    );
    this.write(pen, `${body.name} ${millimetres(body.length)}`, places, colour);
  }

  // Write a text at the first of some places [x, y, align] that is free; the first place if none is.
  write(pen, text, places, colour) {
    pen.font = `12px ${FONT}`;
    const wide = pen.measureText(text).width;
    const boxes = places.map(([x, y, align]) => {
      const left = x - { left: 0, center: wide / 2, right: wide }[align];
      const inside = Math.max(ROOM, Math.min(left, this.paper.view.box[0] - ROOM - wide));
      return [inside, y - 7, inside + wide, y + 7];
    });
    const box = boxes.find((box) => !this.boxes.some((taken) => overlap(box, taken))) ?? boxes[0];
    this.boxes.push(box);
    pen.textAlign = "left";
    pen.textBaseline = "middle";
    pen.strokeStyle = ink.paper;
    pen.lineWidth = 3;
    pen.strokeText(text, box[0], box[1] + 7);
    pen.fillStyle = colour;
    pen.fillText(text, box[0], box[1] + 7);
  }
}

const grounded = (pins) => pins.some((pin) => pin.startsWith("ground."));
const overlap = (first, second) => first[0] < second[2] && second[0] < first[2] && first[1] < second[3] && second[1] < first[3];
const millimetres = (length) => (length >= 10 ? `${Number(length.toPrecision(5))} m` : `${Number((1e3 * length).toPrecision(6))} mm`);
