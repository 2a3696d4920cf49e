// The mechanism as a drawing that is edited with the mouse. Python applies every operation to the text of the model and answers
// with the text, the ideal motion and, if the mechanism does not close, why. Nothing of the model is decided here.

class Sketch {
  // `send(operation)` asks Python, `keep(answer)` makes its text the model, `tell(text)` shows a sentence.
  constructor(canvas, { send, keep, tell, select }) {
    Object.assign(this, { canvas, send, keep, tell, select, view: new View(), drawing: null, chosen: null, drag: null, text: null });
    Object.assign(this, { playing: !matchMedia("(prefers-reduced-motion: reduce)").matches, share: 0, last: 0, busy: false });
    canvas.onpointerdown = (event) => this.press(event);
    canvas.onpointermove = (event) => this.move(event);
    canvas.onpointerup = () => this.release();
    canvas.onpointercancel = () => this.cancel();
    canvas.ondblclick = () => this.fit();
    canvas.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
    requestAnimationFrame((time) => this.frame(time));
  }

  // ------------------------------------------------------------------------------------------------------------- contents

  // Show a text; the view remains if it is of the same model.
  async show(text, other) {
    this.base = text;
    const answer = await this.send({ text });
    if (this.base !== text) return;
    if (!answer.ok) return this.tell(answer.faults.map((one) => one.said).join(" "));
    this.take(answer.said);
    if (other || !this.view.scale) this.fit();
  }

  take(said) {
    this.drawing = new Drawing(said);
    this.text = said.text;
    this.tell(said.fault || said.note);
    this.choose(this.chosen);
  }

  // The selection by name, which survives a new drawing.
  choose(one) {
    const knot = one?.knot && this.drawing.knots.find((other) => other.pins.some((pin) => one.knot.pins.includes(pin)));
    const body = one?.body && this.drawing.index.has(one.body) ? one.body : null;
    this.chosen = knot ? { knot } : body ? { body } : null;
    this.select(this.chosen);
  }

  // Apply an operation and keep its result.
  async apply(operation, args) {
    const answer = await this.send({ text: this.base, operation, arguments: args });
    if (!answer.ok) {
      this.tell(answer.faults.map((one) => one.said).join(" "));
      return false;
    }
    this.base = answer.said.text;
    this.take(answer.said);
    await this.keep(answer.said);
    return true;
  }

  // ------------------------------------------------------------------------------------------------------------- pointer

  pixel({ clientX, clientY }) {
    const box = this.canvas.getBoundingClientRect();
    return [clientX - box.left, clientY - box.top];
  }

  press(event) {
    if (!this.drawing || event.button > 0) return;
    const pixel = this.pixel(event);
    const at = this.view.from(pixel);
    const found = this.drawing.pick(at, NEAR / this.view.scale);
    this.canvas.setPointerCapture(event.pointerId);
    this.drag = { found, pixel, at, moved: false, operation: null };
    this.choose(found?.length ? { body: found.length } : found);
  }

  move(event) {
    if (!this.drawing) return;
    const pixel = this.pixel(event);
    if (!this.drag) {
      const found = this.drawing.pick(this.view.from(pixel), NEAR / this.view.scale);
      this.canvas.style.cursor = found?.knot || found?.length ? "grab" : found ? "pointer" : "default";
      return;
    }
    if (!this.drag.moved && away(pixel, this.drag.pixel) < 4) return;
    this.drag.moved = true;
    if (!this.drag.found || this.drag.found.body) return this.view.moved(event.movementX, event.movementY);
    this.canvas.style.cursor = "grabbing";
    this.drag.operation = this.operation(this.view.from(pixel), event.altKey);
    this.ask();
  }

  // Operation of dragging what was taken hold of to a place.
  operation(place, exactly) {
    const { found, at } = this.drag;
    if (found.knot) {
      const [x, y] = exactly ? place : this.view.rounded(plus(found.knot.at, [place[0] - at[0], place[1] - at[1]]));
      return { operation: "move_point", arguments: { point: found.knot.pins[0], x, y } };
    }
    const body = this.drawing.bodies[this.drawing.index.get(found.length)];
    this.drag.length ??= body.length;
    this.drag.angle ??= this.drawing.poses[0][this.drawing.index.get(found.length)][2];
    const along = turned(-this.drag.angle, [place[0] - at[0], place[1] - at[1]])[0];
    const [length] = exactly ? [this.drag.length + along] : this.view.rounded([this.drag.length + along]);
    return { operation: "set_length", arguments: { body: found.length, length: Math.max(length, 2 / this.view.scale) } };
  }

  // Ask for the last operation of the drag; one request at a time, so that the drawing follows as fast as Python answers.
  async ask() {
    if (this.busy) return;
    this.busy = true;
    const { drag } = this;
    while (drag.operation && drag.operation !== drag.asked) {
      drag.asked = drag.operation;
      const answer = await this.send({ text: this.base, ...drag.asked });
      if (drag.cancelled) break;
      drag.answer = answer.ok ? answer.said : drag.answer;
      if (answer.ok) this.take(answer.said);
      else this.tell(answer.faults.map((one) => one.said).join(" "));
      drag.refused = !answer.ok;
    }
    this.busy = false;
    if (drag.ended) this.finish(drag);
  }

  release() {
    const { drag } = this;
    this.drag = null;
    this.canvas.style.cursor = "default";
    if (!drag?.operation) return;
    drag.ended = true;
    if (!this.busy) this.finish(drag);
  }

  async finish(drag) {
    if (drag.cancelled || !drag.answer) return this.show(this.base);
    this.base = drag.answer.text;
    await this.keep(drag.answer);
  }

  cancel() {
    if (!this.drag) return;
    this.drag.cancelled = true;
    this.drag = null;
    this.show(this.base);
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
      const [wide, tall] = this.view.box;
      if (wide !== made.width || tall !== made.height) this.fit();
      this.draw(made.pen);
    }
    requestAnimationFrame((next) => this.frame(next));
  }

  draw(pen) {
    const { drawing } = this;
    const [, tall] = this.view.box;
    pen.lineJoin = "round";
    pen.lineCap = "round";
    this.curves(pen);
    for (const joint of drawing.joints) if (joint.guide) this.guide(pen, joint);
    const share = this.share > 1 ? 2 - this.share : this.share;
    if (drawing.poses.length > 1 && !this.drag) this.bodies(pen, drawing.pose(share), 0.3);
    this.bodies(pen, drawing.poses[0], 1);
    for (const name of drawing.gaps) this.gap(pen, name);
    for (const spring of drawing.springs) this.spring(pen, spring);
    for (const knot of drawing.knots) this.knot(pen, knot);
    for (const joint of drawing.joints) if (joint.guide) this.block(pen, joint);
    for (const load of drawing.loads) this.load(pen, load);
    for (const body of drawing.bodies) this.name(pen, body);
    this.ruler(pen, tall);
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
      const points = body.outline.map((point) => this.view.to(this.drawing.inBody(k, point, pose)));
      const strong = alpha === 1 && this.chosen?.body === body.name;
      pen.strokeStyle = this.colour(k);
      pen.fillStyle = this.colour(k);
      pen.globalAlpha = alpha;
      pen.lineWidth = alpha < 1 ? 2.5 : strong ? 8 : 5;
      trail(pen, points, body.plate);
      pen.stroke();
      pen.globalAlpha = 0.2 * alpha;
      if (body.plate) pen.fill();
      pen.globalAlpha = 1;
      if (alpha === 1 && points.length === 1) disc(pen, points[0], 8, this.colour(k), ink.card, 2);
    });
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
    const names = joints.length ? joints.map((joint) => joint.name).join(", ") : knot.pins.map((pin) => split(pin)[1]).join(", ");
    this.write(pen, names, [at[0] + 11, at[1] - 11], ink.ink, "left");
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
    const along = turned(angle, joint.guide);
    const from = this.drawing.place(joint.bearing);
    const travel = this.drawing.poses.map((pose) => this.travel(joint, pose));
    const room = 26 / this.view.scale;
    const ends = [Math.min(...travel) - room, Math.max(...travel) + room].map((by) => this.view.to(plus(from, [by * along[0], by * along[1]])));
    pen.strokeStyle = body === "ground" ? ink.ink : this.colour(this.drawing.index.get(body));
    pen.lineWidth = 1.2;
    const across = [-9 * along[1], -9 * along[0]];
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
    const along = turned(angle, joint.guide);
    return (to[0] - from[0]) * along[0] + (to[1] - from[1]) * along[1];
  }

  block(pen, joint) {
    const [body] = split(joint.bearing);
    const angle = body === "ground" ? 0 : this.drawing.poses[0][this.drawing.index.get(body)][2];
    const at = this.view.to(this.drawing.place(joint.journal));
    if (!joint.fixed) return disc(pen, at, 5, ink.ink, ink.card, 2);
    const along = turned(angle, joint.guide);
    const corners = [
      [-13, -8],
      [13, -8],
      [13, 8],
      [-13, 8],
    ].map(([x, y]) => [at[0] + x * along[0] - y * along[1], at[1] - x * along[1] - y * along[0]]);
    trail(pen, corners, true);
    pen.strokeStyle = ink.ink;
    pen.lineWidth = 1.8;
    pen.stroke();
  }

  spring(pen, ends) {
    pen.strokeStyle = ink.spring;
    pen.lineWidth = 1.6;
    pen.setLineDash([5, 3]);
    trail(
      pen,
      ends.map((end) => this.view.to(this.drawing.place(end))),
    );
    pen.stroke();
    pen.setLineDash([]);
  }

  load(pen, { at }) {
    const [x, y] = this.view.to(this.drawing.place(at));
    arrow(pen, [x - 34, y - 34], [x - 6, y - 6], ink.accent, 2);
  }

  // The gap of a joint that does not close.
  gap(pen, name) {
    const joint = this.drawing.joints.find((one) => one.name === name);
    pen.strokeStyle = ink.warm;
    pen.lineWidth = 2.5;
    pen.setLineDash([6, 5]);
    segment(pen, this.view.to(this.drawing.place(joint.bearing)), this.view.to(this.drawing.place(joint.journal)));
    pen.setLineDash([]);
  }

  // Name of a body and, of a link, its length with the handle.
  name(pen, body) {
    const k = this.drawing.index.get(body.name);
    const text = body.length ? `${body.name} ${millimetres(body.length)}` : body.name;
    if (!body.length) {
      const points = body.outline.map((point) => this.view.to(this.drawing.inBody(k, point)));
      const middle = [0, 1].map((axis) => points.reduce((sum, point) => sum + point[axis], 0) / (points.length || 1));
      return this.write(pen, text, [middle[0], middle[1] + (points.length > 2 ? 0 : 22)], this.colour(k), "center");
    }
    const at = this.view.to(this.drawing.handle(body));
    trail(
      pen,
      [
        [at[0], at[1] - 6],
        [at[0] + 6, at[1]],
        [at[0], at[1] + 6],
        [at[0] - 6, at[1]],
      ],
      true,
    );
    pen.fillStyle = ink.card;
    pen.fill();
    pen.strokeStyle = this.colour(k);
    pen.lineWidth = 1.8;
    pen.stroke();
    const angle = this.drawing.poses[0][k][2];
    const side = Math.cos(angle) < 0 ? -1 : 1; // the lower side of the link, or the right one of an upright link
    const [x, y] = [at[0] + 16 * side * Math.sin(angle), at[1] + 16 * side * Math.cos(angle)];
    this.write(pen, text, [x, y], this.colour(k), Math.abs(Math.sin(angle)) < 0.35 ? "center" : x > at[0] ? "left" : "right");
  }

  write(pen, text, [x, y], colour, align) {
    pen.font = `12px ${FONT}`;
    pen.textAlign = align;
    pen.textBaseline = "middle";
    pen.strokeStyle = ink.paper;
    pen.lineWidth = 3;
    pen.strokeText(text, x, y);
    pen.fillStyle = colour;
    pen.fillText(text, x, y);
  }

  ruler(pen, tall) {
    const least = 70 / this.view.scale;
    const power = 10 ** Math.floor(Math.log10(least));
    const length = power * [1, 2, 5, 10].find((one) => one * power >= least);
    pen.strokeStyle = ink.grey;
    pen.lineWidth = 1.2;
    trail(pen, [
      [14, tall - 18],
      [14, tall - 14],
      [14 + length * this.view.scale, tall - 14],
      [14 + length * this.view.scale, tall - 18],
    ]);
    pen.stroke();
    this.write(pen, millimetres(length), [18, tall - 24], ink.grey, "left");
  }
}

const millimetres = (length) => (length >= 10 ? `${Number(length.toPrecision(5))} m` : `${Number((1e3 * length).toPrecision(6))} mm`);
