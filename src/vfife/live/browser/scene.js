// Picture of the mechanism at a moment: bodies, joints with their clearance, springs, loads, forces and traces.

const FIRST_PIN = 0;
const BETWEEN = 2;
const FIRST_TURNS = 1;
const SECOND_TURNS = 2;

const SIGNS = 0.05; // room for signs of the ground around what moves, as a share of it
const EDGES = { side: 40, top: 26, bottom: 44 }; // pixels between the mechanism and the edge of the canvas; the ruler is below
const WAYS = Array.from({ length: 12 }, (_, k) => [Math.cos((Math.PI * (k - 4.5)) / 6), Math.sin((Math.PI * (k - 4.5)) / 6)]);
const PLACES = [11, 18, 28, 42].flatMap((away) => WAYS.map(([x, y]) => [x, y, away])); // of a name: way and distance from its pin

class Scene {
  constructor() {
    this.places = new Map(); // of names
    this.drawnArrows = [];
    this.low = [Number.POSITIVE_INFINITY, Number.POSITIVE_INFINITY];
    this.high = [Number.NEGATIVE_INFINITY, Number.NEGATIVE_INFINITY];
    this.seen = 0;
    this.ways = given.joints.map(() => [0, 0]);
    this.guided = given.joints.map((joint) => joint.strokes.some((stroke) => stroke.points.some((point) => point.slice(6).some(Boolean))));
    this.trails = new Map();
    this.traces = given.bodies.flatMap((body) => body.loose).slice(0, 4);
    this.show = { names: true, forces: true, traces: true };
    this.magnify = 1;
    this.zoom = 1;
    this.shift = [0, 0]; // m
    this.arrows = 1;
    this.largest = 0;
    this.colours = Object.fromEntries(given.bodies.map((body, k) => [body.name, k % 6]));
    this.signs = [...given.joints, ...given.springs];
    for (const point of given.points) this.reach(point);
  }

  reach([x, y]) {
    this.low = [Math.min(this.low[0], x), Math.min(this.low[1], y)];
    this.high = [Math.max(this.high[0], x), Math.max(this.high[1], y)];
  }

  // Extend the drawing by the positions of every fifth output, at most `most` of them a frame, so that the picture does not stall.
  look(running, most) {
    const { store, reader } = running;
    this.seen = Math.max(this.seen, store.begin);
    for (let n = 0; n < most && this.seen < store.end; n++, this.seen += 5) {
      const pose = new Pose(reader, store.data, store.offset(this.seen));
      for (const body of given.bodies) for (const piece of body.outline.pieces) for (const pin of piece) this.reach(pose.place(pin));
      this.size ??= Math.max(this.high[0] - this.low[0], this.high[1] - this.low[1]);
      for (const sign of given.springs) {
        const carried = this.carried(sign, pose, [0, 0]);
        for (const { points } of sign.strokes) for (let i = 0; i < points.length; i += 8) this.reach(carried(points[i]));
      }
      given.joints.forEach((joint, k) => {
        [joint.bearing, joint.journal].forEach((pin, side) => {
          const [[x, y], r] = [pose.place(pin), joint.reaches[side]];
          if (r) for (const corner of [-r, r]) this.reach([x + corner, y + corner]);
        });
        if (!this.guided[k]) return;
        const [bearing, journal, angle] = [pose.place(joint.bearing), pose.place(joint.journal), pose.angle(joint.bearing[0]) + joint.tilt];
        const way = Math.cos(angle) * (journal[0] - bearing[0]) + Math.sin(angle) * (journal[1] - bearing[1]);
        this.ways[k] = [Math.min(this.ways[k][0], way), Math.max(this.ways[k][1], way)];
      });
    }
  }

  // Width and height of what moves (m), with room for the signs of the ground.
  get span() {
    const whole = Math.max(...[0, 1].map((axis) => this.high[axis] - this.low[axis]), 1e-9);
    return [0, 1].map((axis) => Math.max(this.high[axis] - this.low[axis], 1e-9) + 2 * SIGNS * whole);
  }

  // Height of the canvas that the mechanism fills at a width.
  heightAt(width) {
    const [wide, tall] = this.span;
    return ((width - 2 * EDGES.side) * tall) / wide + EDGES.top + EDGES.bottom;
  }

  // Return the map from metres to pixels.
  view(width, height) {
    const { side, top, bottom } = EDGES;
    const [wide, tall] = this.span;
    const scale = this.zoom * Math.min(Math.max(width - 2 * side, 40) / wide, Math.max(height - top - bottom, 40) / tall);
    const middle = [0, 1].map((axis) => 0.5 * (this.low[axis] + this.high[axis]) + this.shift[axis]);
    this.scale = scale;
    this.size = Math.max(...[0, 1].map((axis) => this.high[axis] - this.low[axis]), 1e-9) / this.zoom; // symbols keep their size
    this.box = [width, height];
    const up = top + 0.5 * (height - top - bottom);
    return (p) => [width / 2 + scale * (p[0] - middle[0]), up - scale * (p[1] - middle[1])];
  }

  // Zoom by a factor about a point of the canvas, in pixels from its centre; 0 resets the zoom.
  zoomed(factor, x = 0, y = 0) {
    const previous = this.zoom;
    this.zoom = Math.min(Math.max(previous * factor, 1), 2000);
    if (this.zoom === 1) this.shift = [0, 0];
    else this.moved((x * previous) / this.zoom - x, (y * previous) / this.zoom - y);
    this.scale *= this.zoom / previous;
  }

  // Move the view by pixels.
  moved(dx, dy) {
    this.shift = [this.shift[0] - dx / this.scale, this.shift[1] + dy / this.scale];
  }

  draw(pen, width, height, running, head, comparison) {
    const to = this.view(width, height);
    const pose = Pose.at(running, head);
    if (!pose) return;
    this.last = { to, pose };
    pen.lineJoin = "round";
    pen.lineCap = "round";
    this.drawnArrows = []; // [from, to] in pixels, which names should not cover
    if (this.show.forces) this.measureForces(running);
    this.ruler(pen, width, height);
    const ghost = comparison && Pose.at(comparison, Math.min(head, comparison.store.end - 1));
    if (ghost) this.ghost(pen, to, ghost);
    if (this.show.traces) this.trace(pen, to, running, head, pose);
    this.under(pen, to, pose);
    for (const body of given.bodies) this.body(pen, to, pose, body);
    this.over(pen, to, pose);
    this.loads(pen, to, pose);
    this.play(pen, to, pose, ghost);
    if (this.show.forces) this.forces(pen, to, pose);
    if (this.show.names) this.names(pen, to, pose);
  }

  colour(name) {
    return name === "ground" || !(name in this.colours) ? ink.ink : ink.bodies[this.colours[name]];
  }

  get thick() {
    return Math.min(Math.max(0.028 * this.size * this.scale, 5), 13);
  }

  body(pen, to, pose, { name, outline }) {
    pen.setLineDash([]);
    const colour = this.colour(name);
    for (const piece of outline.pieces) {
      const points = piece.map((pin) => to(pose.place(pin)));
      if (points.length === 1) {
        disc(pen, points[0], 0.6 * this.thick, colour, ink.paper);
        continue;
      }
      pen.strokeStyle = colour;
      if (outline.plate) {
        trail(pen, points, true);
        pen.globalAlpha = 0.22;
        pen.fillStyle = colour;
        pen.fill();
        pen.globalAlpha = 1;
        pen.lineWidth = 0.4 * this.thick;
        pen.stroke();
        continue;
      }
      const wide = outline.pieces.length > 1 ? 0.6 * this.thick : this.thick;
      trail(pen, points);
      pen.lineWidth = wide;
      pen.stroke();
      pen.strokeStyle = ink.paper;
      pen.globalAlpha = 0.62;
      pen.lineWidth = wide - Math.max(2.4, 0.3 * wide);
      pen.stroke();
      pen.globalAlpha = 1;
      if (outline.dots) for (const point of points.slice(1, -1)) disc(pen, point, 1.8, colour, colour);
    }
  }

  // Draw the bodies of the setting kept for comparison as dashed lines.
  ghost(pen, to, pose) {
    pen.strokeStyle = ink.other;
    pen.lineWidth = 1.6;
    pen.setLineDash([5, 4]);
    for (const body of given.bodies) {
      for (const piece of body.outline.pieces) {
        trail(
          pen,
          piece.map((pin) => to(pose.place(pin))),
        );
        pen.stroke();
      }
    }
    pen.setLineDash([]);
  }

  trace(pen, to, running, head, pose) {
    const { store } = running;
    const from = Math.max(store.begin, Math.floor(head) - (perTurn ?? wholeRun));
    pen.lineWidth = 1.5;
    this.traces.forEach((pin, k) => {
      const way = this.way(running, pin);
      pen.strokeStyle = ink.bodies[(k + 1) % 6];
      pen.setLineDash(DASHES[k % 6]);
      pen.beginPath();
      const stride = Math.max(1, Math.ceil((head - from) / 900));
      for (let n = from; n <= head; n += stride) pen.lineTo(...to(way(n)));
      pen.lineTo(...to(pose.place(pin)));
      pen.stroke();
      pen.setLineDash([]);
      disc(pen, to(pose.place(pin)), 3, ink.bodies[(k + 1) % 6], ink.paper);
    });
  }

  // Return a function of the output that gives the position of a pin, cached until the ring buffer overwrites the output.
  way({ reader, store }, pin) {
    if (!this.trails.has(pin) || this.trails.get(pin).store !== store) {
      const places = new Float64Array(2 * store.capacity);
      this.trails.set(pin, { store, places, of: new Int32Array(store.capacity).fill(-1) });
    }
    const { places, of } = this.trails.get(pin);
    return (n) => {
      const at = n % store.capacity;
      if (of[at] !== n) {
        places.set(new Pose(reader, store.data, store.offset(n)).place(pin), 2 * at);
        of[at] = n;
      }
      return [places[2 * at], places[2 * at + 1]];
    };
  }

  // -------------------------------------------------------------------------------------------------- signs of joints

  // Draw the symbols behind bodies: ground, rails, blocks, in which rods end, and wheels with a spoke that shows their rotation.
  under(pen, to, pose) {
    this.strokes(pen, to, pose, (stroke) => stroke.is === "surface" || stroke.is === "curve");
    this.strokes(pen, to, pose, (stroke) => stroke.is === "block");
    for (const sign of given.springs) {
      (sign.wheels ?? []).forEach(([particle, radius], k) => {
        const at = pose.place(k ? sign.journal : sign.bearing);
        const angle = pose.angle(particle);
        pen.strokeStyle = this.colour(sign.bodies[k]);
        pen.lineWidth = 1.4;
        trail(pen, [at, [at[0] + radius * Math.cos(angle), at[1] + radius * Math.sin(angle)]].map(to));
        pen.stroke();
      });
    }
  }

  // Draw the symbols in front of bodies.
  over(pen, to, pose) {
    this.strokes(pen, to, pose, (stroke) => stroke.is === "mark");
  }

  strokes(pen, to, pose, wanted) {
    this.signs.forEach((sign, k) => {
      const carried = this.carried(sign, pose, this.ways[k] ?? [0, 0]);
      for (const stroke of sign.strokes)
        if (wanted(stroke))
          this.stroke(
            pen,
            stroke,
            stroke.points.map((point) => to(carried(point))),
            sign,
          );
    });
  }

  // Return the map from a point of a stroke to its position; coefficients as in live/page/strokes.py.
  carried(sign, pose, way) {
    const [first, second] = [pose.place(sign.bearing), pose.place(sign.journal)];
    const angles = [0, pose.angle(sign.turner ?? sign.bearing[0]), pose.angle(sign.journal[0])];
    const turned = angles.map((angle) => [Math.cos(angle), Math.sin(angle)]);
    const { size } = this;
    return ([carrier, turner, ...v]) => {
      if (carrier === BETWEEN) {
        const [dx, dy] = [second[0] - first[0], second[1] - first[1]];
        const across = (v[1] + size * v[3]) / (Math.hypot(dx, dy) || 1);
        return [first[0] + v[0] * dx - across * dy, first[1] + v[0] * dy + across * dx];
      }
      const [x, y] = [0, 1].map((axis) => v[axis] + size * v[2 + axis] + way[0] * v[4 + axis] + way[1] * v[6 + axis]);
      const [c, s] = turned[turner === FIRST_TURNS || turner === SECOND_TURNS ? turner : 0];
      const origin = carrier === FIRST_PIN ? first : second;
      return [origin[0] + c * x - s * y, origin[1] + s * x + c * y];
    };
  }

  stroke(pen, stroke, points, sign) {
    const ends = { bearing: sign.bodies[0], journal: sign.bodies[1] };
    const colour = { ink: ink.ink, grey: ink.grey, spring: ink.spring }[stroke.colour] ?? this.colour(ends[stroke.colour] ?? "ground");
    pen.strokeStyle = colour;
    pen.setLineDash([]);
    if (stroke.is === "surface") return hatched(pen, points);
    if (stroke.is === "mark") return mark(pen, stroke.shape, points[0], colour);
    trail(pen, points, stroke.is === "block");
    if (stroke.is === "block") {
      pen.fillStyle = ink.paper;
      pen.fill();
      pen.globalAlpha = 0.3;
      pen.fillStyle = colour;
      pen.fill();
      pen.globalAlpha = 1;
    }
    pen.lineWidth = stroke.width ?? 1.8;
    pen.globalAlpha = stroke.fade ?? 1;
    pen.setLineDash({ "-.": [8, 3, 2, 3], ":": [2, 3] }[stroke.dashes] ?? []);
    pen.stroke();
    pen.setLineDash([]);
    pen.globalAlpha = 1;
  }

  // ------------------------------------------------------------------------------------------------------ play, forces

  // Enlargement of clearances: it decreases with the zoom, down to true scale.
  get drawnLarger() {
    return Math.max(this.magnify / this.zoom, 1);
  }

  // Draw enlarged clearance circles with the journal's centre, coloured by the joint force.
  play(pen, to, pose, ghost) {
    given.contacts.forEach((contact, k) => {
      if (contact.kind !== "bearing") return;
      const joint = given.joints.find((candidate) => candidate.name === contact.joint);
      const radius = pose.reader.plays[k] * this.drawnLarger * this.scale;
      if (radius < 2.5) return;
      const at = to(pose.place(joint.bearing));
      const away = pose.reader.eccentricity(pose.data, pose.from, k).map((value) => value * this.drawnLarger * this.scale);
      const force = Math.hypot(...pose.reader.force(pose.data, pose.from, contact.joint));
      disc(pen, at, radius, ink.ink, ink.paper, 1.2, 0.86);
      const share = this.largest ? Math.sqrt(force / this.largest) : 0;
      pen.strokeStyle = ink.grey;
      pen.lineWidth = 1;
      trail(pen, [at, [at[0] + away[0], at[1] - away[1]]]);
      pen.stroke();
      if (ghost) {
        const ghostAt = ghost.reader.eccentricity(ghost.data, ghost.from, k).map((value) => value * this.drawnLarger * this.scale);
        pen.strokeStyle = ink.other;
        pen.setLineDash([3, 2]);
        pen.beginPath();
        pen.arc(at[0], at[1], ghost.reader.plays[k] * this.drawnLarger * this.scale, 0, 2 * Math.PI);
        pen.stroke();
        disc(pen, [at[0] + ghostAt[0], at[1] - ghostAt[1]], 2.5, ink.other, ink.paper, 1.4);
      }
      disc(pen, [at[0] + away[0], at[1] - away[1]], Math.max(2.5, 0.16 * radius), ink.ink, heat(share), 0.8);
    });
  }

  forces(pen, to, pose) {
    if (!this.largest) return;
    for (const joint of given.joints) {
      const force = pose.reader.force(pose.data, pose.from, joint.name);
      const size = Math.hypot(...force);
      const length = Math.min(0.16 * this.size * this.scale * this.arrows * (size / this.reference), 0.45 * this.size * this.scale);
      if (length < 4) continue;
      const at = to(pose.place(joint.journal));
      const tip = [at[0] + (length * force[0]) / size, at[1] - (length * force[1]) / size];
      arrow(pen, at, tip, ink.warm, joint.name === selected.joint ? 3 : 2);
      this.drawnArrows.push([at, tip]);
    }
  }

  // Set the force at which an arrow has its standard length: the largest of the turns shown, at most 1.5 times the ideal one, so
  // that impacts do not shrink all other arrows.
  measureForces(running) {
    const largestForce = (turns) => Math.max(0, ...turns.flatMap((turn) => Object.values(turn.force)));
    const largest = largestForce(running.turns.shown);
    const idealForce = running.idealTurns ? largestForce(running.idealTurns.done) : 0;
    this.largest = largest;
    this.reference = idealForce > 1e-9 * largest ? Math.min(largest, 1.5 * idealForce) : largest;
  }

  loads(pen, to, pose) {
    for (const { at, acts, turner } of given.loads) {
      const size = Math.hypot(acts[0], acts[1]);
      const place = to(pose.place(at));
      if (size > 0) {
        const [c, s] = [Math.cos(pose.angle(turner)), Math.sin(pose.angle(turner))];
        const away = [(c * acts[0] - s * acts[1]) / size, (s * acts[0] + c * acts[1]) / size];
        const length = 0.13 * this.size * this.scale;
        const from = [place[0] - length * away[0], place[1] + length * away[1]];
        arrow(pen, from, place, ink.accent, 2);
        this.drawnArrows.push([from, place]);
      }
    }
  }

  // ------------------------------------------------------------------------------------------------------------- names

  // A name keeps its place beside its pin or bar until it would cover something there; then it takes the place where it covers least.
  names(pen, to, pose) {
    const [lines, boxes] = [this.covered(to, pose), this.circles(to, pose)];
    pen.textAlign = "center";
    pen.textBaseline = "middle";
    const write = (key, text, at, colour) => {
      const half = [0.5 * pen.measureText(text).width + 2, 8];
      const box = ([dx, dy, away]) => [at[0] + dx * (half[0] + away), at[1] + dy * (half[1] + away)];
      const cost = (place) => this.costOf(box(place), half, lines, boxes) + 0.25 * place[2];
      let place = this.places.get(key);
      if (!place || cost(place) > 0.25 * place[2] + 2) {
        const best = PLACES.map((place) => [cost(place), place]).reduce((a, b) => (b[0] < a[0] ? b : a));
        if (!place || best[0] < cost(place) - 4) place = best[1];
        this.places.set(key, place);
      }
      const [x, y] = box(place);
      boxes.push([x, y, ...half]);
      pen.strokeStyle = ink.paper;
      pen.lineWidth = 3.5;
      pen.strokeText(text, x, y);
      pen.fillStyle = colour;
      pen.fillText(text, x, y);
    };
    pen.font = `600 12px ${FONT}`;
    for (const [k, joint] of given.joints.entries()) {
      const at = to(pose.place(this.guided[k] ? joint.journal : joint.bearing));
      write(`joint ${joint.name}`, joint.name, at, joint.name === selected.joint ? ink.warm : ink.ink);
    }
    pen.font = `12px ${FONT}`;
    for (const body of given.bodies) {
      const pins = body.outline.pieces.flat();
      const [a, b] = [pins[0], pins[Math.max(1, Math.floor(pins.length / 2))] ?? pins[0]].map((pin) => to(pose.place(pin)));
      write(`body ${body.name}`, body.name, [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])], this.colour(body.name));
    }
  }

  // Points along bars and arrows, which names should not cover.
  covered(to, pose) {
    const points = [];
    const cover = ([ax, ay], [bx, by]) => {
      const count = Math.min(Math.ceil(Math.hypot(bx - ax, by - ay) / 9), 60);
      for (let n = 0; n <= count; n++) points.push([ax + (n / count) * (bx - ax), ay + (n / count) * (by - ay)]);
    };
    for (const body of given.bodies) {
      for (const piece of body.outline.pieces) {
        const corners = piece.map((pin) => to(pose.place(pin)));
        for (let k = 0; k + 1 < corners.length; k++) cover(corners[k], corners[k + 1]);
      }
    }
    for (const ends of this.drawnArrows) cover(...ends);
    return points;
  }

  // Boxes of pins and of the clearance circles as they are drawn.
  circles(to, pose) {
    const pins = given.joints.flatMap((joint) => [joint.bearing, joint.journal].map((pin) => [...to(pose.place(pin)), 5, 5]));
    const plays = given.contacts.flatMap((contact, k) => {
      const radius = pose.reader.plays[k] * this.drawnLarger * this.scale;
      if (contact.kind !== "bearing" || radius < 2.5) return [];
      const joint = given.joints.find((candidate) => candidate.name === contact.joint);
      return [[...to(pose.place(joint.bearing)), radius, radius]];
    });
    return [...pins, ...plays];
  }

  costOf([x, y], [wide, tall], lines, boxes) {
    let cost = 0;
    for (const [a, b] of lines) if (Math.abs(a - x) < wide + 3 && Math.abs(b - y) < tall + 2) cost += 3;
    for (const [a, b, w, h] of boxes) if (Math.abs(a - x) < wide + w && Math.abs(b - y) < tall + h) cost += 400;
    const [width, height] = this.box;
    return x < wide || x > width - wide || y < tall || y > height - tall - 24 ? cost + 4000 : cost;
  }

  // Draw scales of length and force at the lower left.
  ruler(pen, width, height) {
    const length = nice((0.22 * width) / this.scale);
    const [x, y] = [14, height - 12];
    pen.strokeStyle = ink.grey;
    pen.lineWidth = 1.2;
    pen.setLineDash([]);
    trail(pen, [
      [x, y - 4],
      [x, y],
      [x + length * this.scale, y],
      [x + length * this.scale, y - 4],
    ]);
    pen.stroke();
    pen.fillStyle = ink.grey;
    pen.font = `11px ${FONT}`;
    pen.textAlign = "left";
    pen.textBaseline = "alphabetic";
    pen.fillText(quantity(length, "m"), x + 4, y - 6);
    if (!this.show.forces || !this.largest) return;
    const unit = 0.16 * this.size * this.scale * this.arrows; // length of the arrow of the reference force, in pixels
    const force = nice((80 / unit) * this.reference);
    const from = [x + length * this.scale + 24, y - 2];
    const long = (force / this.reference) * unit;
    arrow(pen, from, [from[0] + long, from[1]], ink.warm, 2);
    pen.fillStyle = ink.grey;
    pen.fillText(quantity(force, "N"), from[0], from[1] - 7);
  }

  // Return what is under the pointer: a joint, a traced point, or a point of a body.
  pick(x, y) {
    if (!this.last) return null;
    const { to, pose } = this.last;
    const distance = (pin) => Math.hypot(to(pose.place(pin))[0] - x, to(pose.place(pin))[1] - y);
    const joints = given.joints.map((joint) => [distance(joint.journal), joint.name]).sort((a, b) => a[0] - b[0]);
    if (joints[0]?.[0] < 18) return { joint: joints[0][1] };
    const trace = this.traces.findIndex((pin) => distance(pin) < 10);
    if (trace >= 0) return { trace };
    return this.onBody(x, y);
  }

  onBody(x, y) {
    const { to, pose } = this.last;
    let best = { gap: 16, pin: null };
    for (const body of given.bodies) {
      for (const piece of body.outline.pieces) {
        for (let k = 0; k + 1 < piece.length; k++) {
          const [[ax, ay], [bx, by]] = [to(pose.place(piece[k])), to(pose.place(piece[k + 1]))];
          const share = Math.min(Math.max(((x - ax) * (bx - ax) + (y - ay) * (by - ay)) / ((bx - ax) ** 2 + (by - ay) ** 2 || 1), 0), 1);
          const gap = Math.hypot(ax + share * (bx - ax) - x, ay + share * (by - ay) - y);
          if (gap >= best.gap) continue;
          const rigid = piece[k][0] === piece[k + 1][0];
          const pin = rigid ? piece[k].map((value, i) => value + share * (piece[k + 1][i] - value)) : piece[share < 0.5 ? k : k + 1];
          best = { gap, pin };
        }
      }
    }
    return best.pin && { pin: best.pin };
  }
}
