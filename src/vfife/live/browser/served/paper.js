// The drawing of a mechanism on a canvas: its view, its ideal motion, and the signs of its parts.

const REACH = 7; // pixels from a line within which the pointer takes hold of it
const RING = 26; // pixels, radius of the arc of a driver

class Paper {
  constructor(canvas) {
    Object.assign(this, { canvas, view: new View(), drawing: null, chosen: null, share: 0, last: 0 });
    this.labels = new Labels(this);
    this.playing = !matchMedia("(prefers-reduced-motion: reduce)").matches;
    canvas.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
    requestAnimationFrame((time) => this.frame(time));
  }

  pixel({ clientX, clientY }) {
    const box = this.canvas.getBoundingClientRect();
    return [clientX - box.left, clientY - box.top];
  }

  wheel(event) {
    event.preventDefault();
    this.view.zoomed(2 ** (-event.deltaY / 300), this.pixel(event));
  }

  fit() {
    const made = canvasFor(this.canvas);
    if (!made || !this.drawing) return;
    this.view.box = [made.width, made.height];
    this.view.fit(this.drawing.reach, this.drawing.size);
  }

  // ------------------------------------------------------------------------------------------------------------- drawing

  frame(time) {
    const passed = Math.min(time - this.last, 100) / 1000;
    this.last = time;
    const made = canvasFor(this.canvas);
    if (made && this.drawing) {
      if (this.playing) this.share = (this.share + passed / 4) % (this.drawing.closed ? 1 : 2);
      if (!this.view.scale) this.fit();
      this.resize(made);
      this.draw(made.pen);
    }
    requestAnimationFrame((next) => this.frame(next));
  }

  // Follow the size of the canvas. Another width shows everything; lines that come above the paper leave the view where it is.
  resize({ width, height }) {
    const { top } = this.canvas.getBoundingClientRect();
    const middle = top + height / 2;
    if (width !== this.view.box[0]) this.fit();
    else if (this.level !== undefined && middle !== this.level) this.view.moved(0, this.level - middle);
    this.view.box = [width, height];
    this.level = middle;
  }

  draw(pen) {
    const { drawing } = this;
    const [, tall] = this.view.box;
    pen.lineJoin = "round";
    pen.lineCap = "round";
    this.curves(pen);
    for (const joint of drawing.joints) if (joint.guide) this.guide(pen, joint);
    const share = this.share > 1 ? 2 - this.share : this.share;
    if (drawing.poses.length > 1 && !this.still) this.bodies(pen, drawing.pose(share), 0.3);
    this.bodies(pen, drawing.poses[0], 1);
    for (const name of drawing.gaps) this.gap(pen, name);
    for (const spring of drawing.springs) this.spring(pen, spring);
    for (const knot of drawing.knots) this.knot(pen, knot);
    for (const joint of drawing.joints) if (joint.guide) this.block(pen, joint);
    for (const load of drawing.loads) this.load(pen, load);
    for (const body of drawing.bodies) if (body.driver) this.driver(pen, body);
    for (const body of drawing.bodies) if (body.length) this.handle(pen, body);
    this.labels.draw(pen);
    this.ruler(pen, tall);
    this.above(pen);
  }

  colour(k) {
    return ink.bodies[k % 6];
  }

  curves(pen) {
    this.drawing.knots.forEach((knot, k) => {
      const loose = knot.joints.length === 0;
      pen.strokeStyle = loose ? ink.warm : ink.grey;
      pen.globalAlpha = loose ? 0.9 : 0.4;
      pen.lineWidth = loose ? 1.6 : 1;
      if (!this.drawing.curves.length || knot.pins.some((pin) => pin.startsWith("ground."))) return;
      trail(
        pen,
        this.drawing.curves[k].map((place) => this.view.to(place)),
      );
      pen.stroke();
    });
    pen.globalAlpha = 1;
  }

  bodies(pen, pose, alpha) {
    pen.setLineDash([]);
    this.drawing.bodies.forEach((body, k) => {
      const strong = alpha === 1 && this.chosen?.body === body.name;
      const points = this.outline(pen, body, pose);
      pen.strokeStyle = this.colour(k);
      pen.fillStyle = this.colour(k);
      pen.globalAlpha = alpha;
      pen.lineWidth = alpha < 1 ? 2.5 : strong ? 8 : 5;
      pen.stroke();
      pen.globalAlpha = 0.2 * alpha;
      if (body.plate) pen.fill();
      pen.globalAlpha = 1;
      if (alpha === 1 && points.length === 1) disc(pen, points[0], 8, this.colour(k), ink.card, 2);
    });
  }

  // Lay the path of a body's outline and return its places in pixels.
  outline(pen, body, pose) {
    const k = this.drawing.index.get(body.name);
    const points = body.outline.map((point) => this.view.to(this.drawing.inBody(k, point, pose)));
    trail(pen, points, body.plate);
    return points;
  }

  // A point with its signs: the ground, the kind of its joints, and its name.
  knot(pen, knot) {
    const at = this.view.to(knot.at);
    const joints = this.drawing.joints.filter((joint) => knot.joints.includes(joint.name));
    const chosen = this.chosen?.knot?.pins.includes(knot.pins[0]);
    if (knot.pins.some((pin) => pin.startsWith("ground."))) this.ground(pen, at);
    const sliding = joints.some((joint) => joint.guide) && !joints.some((joint) => joint.pinned);
    if (joints.some((joint) => joint.kind === "weld")) mark(pen, "square", at, ink.ink);
    else if (!sliding) disc(pen, at, chosen ? 8 : 6, chosen ? ink.accent : ink.ink, joints.length ? ink.card : ink.warm, chosen ? 3 : 1.8);
    if (joints.some((joint) => joint.pinned && joint.clearance)) disc(pen, at, 2.5, ink.ink, ink.ink);
  }

  ground(pen, [x, y]) {
    pen.strokeStyle = ink.ink;
    pen.lineWidth = 1.4;
    trail(
      pen,
      [
        [x, y],
        [x - 9, y + 16],
        [x + 9, y + 16],
      ],
      true,
    );
    pen.stroke();
    hatched(pen, [
      [x - 15, y + 16],
      [x + 15, y + 16],
      [x + 15, y + 22],
      [x - 15, y + 22],
    ]);
  }

  // Line of a guide over the travel of its journal.
  guide(pen, joint) {
    const [body] = split(joint.bearing);
    const angle = body === "ground" ? 0 : this.drawing.poses[0][this.drawing.index.get(body)][2];
    const direction = turned(angle, joint.guide);
    const from = this.drawing.place(joint.bearing);
    const travel = this.drawing.poses.map((pose) => this.travel(joint, pose));
    const room = (this.halves(joint)[0] + 13) / this.view.scale;
    const ends = [Math.min(...travel) - room, Math.max(...travel) + room].map((by) =>
      this.view.to(plus(from, [by * direction[0], by * direction[1]])),
    );
    pen.strokeStyle = body === "ground" ? ink.ink : this.colour(this.drawing.index.get(body));
    pen.lineWidth = 1.2;
    const wall = this.halves(joint)[1] + 1;
    const across = [-wall * direction[1], -wall * direction[0]];
    for (const side of [1, -1]) {
      trail(
        pen,
        ends.map(([x, y]) => [x + side * across[0], y + side * across[1]]),
      );
      pen.stroke();
    }
  }

  travel(joint, pose) {
    const [body] = split(joint.bearing);
    const angle = body === "ground" ? 0 : pose[this.drawing.index.get(body)][2];
    const [from, to] = [this.drawing.place(joint.bearing, pose), this.drawing.place(joint.journal, pose)];
    const direction = turned(angle, joint.guide);
    return (to[0] - from[0]) * direction[0] + (to[1] - from[1]) * direction[1];
  }

  // Half length and height (px) of a block as the model has it, and large enough to be seen.
  halves({ block: [length, height] }) {
    return [Math.max(13, 0.5 * length * this.view.scale), Math.max(8, 0.5 * height * this.view.scale)];
  }

  block(pen, joint) {
    const [body] = split(joint.bearing);
    const angle = body === "ground" ? 0 : this.drawing.poses[0][this.drawing.index.get(body)][2];
    const at = this.view.to(this.drawing.place(joint.journal));
    if (!joint.fixed) return disc(pen, at, 5, ink.ink, ink.card, 2);
    const direction = turned(angle, joint.guide);
    const [a, b] = this.halves(joint);
    const corners = [
      [-a, -b],
      [a, -b],
      [a, b],
      [-a, b],
    ].map(([x, y]) => [at[0] + x * direction[0] - y * direction[1], at[1] - x * direction[1] - y * direction[0]]);
    trail(pen, corners, true);
    pen.strokeStyle = ink.ink;
    pen.lineWidth = 1.8;
    pen.stroke();
  }

  spring(pen, spring) {
    pen.strokeStyle = ink.spring;
    pen.lineWidth = this.chosen?.spring === spring.name ? 3.2 : 1.6;
    pen.setLineDash([5, 3]);
    segment(pen, ...this.springLine(spring));
    pen.setLineDash([]);
  }

  springLine({ ends }) {
    return ends.map((end) => this.view.to(this.drawing.place(end)));
  }

  load(pen, load) {
    arrow(pen, ...this.loadLine(load), ink.accent, this.chosen?.load === load.name ? 3.5 : 2);
  }

  // Ends of the arrow of a force in pixels, along the force; a load without one is drawn aslant.
  loadLine({ at, force }) {
    const [x, y] = this.view.to(this.drawing.place(at));
    const size = Math.hypot(...force);
    const [ux, uy] = size ? [force[0] / size, -force[1] / size] : [Math.SQRT1_2, Math.SQRT1_2];
    return [
      [x - 56 * ux, y - 56 * uy],
      [x - 8 * ux, y - 8 * uy],
    ];
  }

  // Arc with an arrow around the pivot of a driven body, in the direction in which it turns.
  driver(pen, body) {
    const points = this.driverArc(body);
    const colour = this.colour(this.drawing.index.get(body.name));
    pen.strokeStyle = colour;
    pen.lineWidth = this.chosen?.driver === body.driver.name ? 4 : 2.2;
    trail(pen, points.slice(0, -1));
    pen.stroke();
    arrow(pen, points.at(-3), points.at(-1), colour, 2.2);
  }

  driverArc(body) {
    const { drawing } = this;
    const k = drawing.index.get(body.name);
    const pinsOfBody = Object.keys(body.pins).map((pin) => `${body.name}.${pin}`);
    const pivot = drawing.knots.find(({ pins }) => pinsOfBody.some((pin) => pins.includes(pin)) && pins.some((pin) => pin.startsWith("ground.")));
    const [x, y] = this.view.to(pivot?.at ?? drawing.poses[0][k]);
    const [start, next] = [drawing.poses[0][k][2], drawing.poses[1]?.[k][2] ?? Number.POSITIVE_INFINITY];
    const hand = next < start ? -1 : 1;
    return Array.from({ length: 13 }, (_, step) => start + hand * (0.45 + 0.17 * step)).map((angle) => [
      x + RING * Math.cos(angle),
      y - RING * Math.sin(angle),
    ]);
  }

  // What the pointer takes hold of at a pixel: a point, a force, a driver, the length of a link, a spring, a body, or nothing.
  part(pixel) {
    const { drawing, view } = this;
    const [at, tolerance] = [view.from(pixel), NEAR / view.scale];
    const distance = (line) =>
      least(
        line.slice(1).map((to, k) => away(footOnLine(line[k], to, pixel), pixel)),
        (number) => number,
      );
    const knot = drawing.knotNear(at, tolerance);
    if (knot) return { knot };
    const load = least(drawing.loads, (load) => distance(this.loadLine(load)), REACH);
    if (load) return { load: load.name };
    const driven = least(
      drawing.bodies.filter((body) => body.driver),
      (body) => distance(this.driverArc(body)),
      REACH,
    );
    if (driven) return { driver: driven.driver.name };
    const link = drawing.lengthNear(at, tolerance);
    if (link) return { length: link.name };
    const spring = least(drawing.springs, (spring) => distance(this.springLine(spring)), REACH);
    if (spring) return { spring: spring.name };
    const body = drawing.bodyNear(at, tolerance);
    return body && { body: body.name };
  }

  // Place in metres beside which a sentence about a part is written.
  middle({ knot, body, load, spring, driver }) {
    const { drawing, view } = this;
    if (knot) return knot.at;
    if (load) return drawing.place(drawing.loads.find(({ name }) => name === load).at);
    if (spring) return drawing.place(drawing.springs.find(({ name }) => name === spring).ends[0]);
    const shown = drawing.bodies.find((candidate) => candidate.name === body || (driver && candidate.driver?.name === driver));
    if (driver) return view.from(this.driverArc(shown)[6]);
    return shown.length ? drawing.handle(shown) : drawing.inBody(drawing.index.get(body), shown.outline[0] ?? [0, 0]);
  }

  // Mark a part in a colour.
  mark(pen, { knot, body, load, spring, driver }, colour) {
    const named = (parts, wanted) => parts.find(({ name }) => name === wanted);
    pen.strokeStyle = colour;
    pen.globalAlpha = 0.75;
    pen.lineWidth = 9;
    if (knot) {
      pen.beginPath();
      pen.arc(...this.view.to(knot.at), 13, 0, 2 * Math.PI);
      pen.lineWidth = 4;
    } else if (body) {
      const [at, ...corners] = this.outline(pen, named(this.drawing.bodies, body));
      if (!corners.length) pen.arc(...at, 11, 0, 2 * Math.PI);
    } else if (load) trail(pen, this.loadLine(named(this.drawing.loads, load)));
    else if (spring) trail(pen, this.springLine(named(this.drawing.springs, spring)));
    else trail(pen, this.driverArc(this.drawing.bodies.find((body) => body.driver?.name === driver)));
    pen.stroke();
    pen.globalAlpha = 1;
  }

  // The gap of a joint that does not close.
  gap(pen, name) {
    const joint = this.drawing.joints.find((joint) => joint.name === name);
    pen.strokeStyle = ink.warm;
    pen.lineWidth = 2.5;
    pen.setLineDash([6, 5]);
    segment(pen, this.view.to(this.drawing.place(joint.bearing)), this.view.to(this.drawing.place(joint.journal)));
    pen.setLineDash([]);
  }

  // Handle of the length of a link.
  handle(pen, body) {
    const [x, y] = this.view.to(this.drawing.handle(body));
    trail(
      pen,
      [
        [x, y - 6],
        [x + 6, y],
        [x, y + 6],
        [x - 6, y],
      ],
      true,
    );
    pen.fillStyle = ink.card;
    pen.fill();
    pen.strokeStyle = this.colour(this.drawing.index.get(body.name));
    pen.lineWidth = 1.8;
    pen.stroke();
  }

  ruler(pen, tall) {
    const shortest = 70 / this.view.scale;
    const power = 10 ** Math.floor(Math.log10(shortest));
    const length = power * [1, 2, 5, 10].find((factor) => factor * power >= shortest);
    pen.strokeStyle = ink.grey;
    pen.lineWidth = 1.2;
    trail(pen, [
      [14, tall - 18],
      [14, tall - 14],
      [14 + length * this.view.scale, tall - 14],
      [14 + length * this.view.scale, tall - 18],
    ]);
    pen.stroke();
    this.labels.write(pen, millimetres(length), [[18, tall - 24, "left"]], ink.grey);
  }
}
