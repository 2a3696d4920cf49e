// Downloads: the model at this setting, the stored outputs as CSV, pictures as PNG and SVG.

function hand(name, content, type) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(content instanceof Blob ? content : new Blob([content], { type }));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

const fileName = (ending) => `${given.name.replace(/[^\p{L}\p{N}]+/gu, "_").replace(/^_+|_+$/g, "") || "mechanism"}${ending}`;
const quoted = (text) => (/[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);

// Stored outputs as CSV, one per line, in SI units.
function csvOf(running) {
  const { reader, store } = running;
  const joints = Object.keys(own.joints);
  const driven = Object.keys(own.torques).map((name) => TORQUE + name);
  const head = [factors ? "load factor (1)" : "time (s)"];
  if (given.crank) head.push("crank_angle (deg)");
  for (const name of joints) head.push(`force ${name} x (N)`, `force ${name} y (N)`, `force ${name} largest since the line before (N)`);
  for (const name of driven) head.push(`${name} (N m)`, `${name} largest since the line before (N m)`);
  for (const { name } of given.contacts) head.push(`eccentricity ${name} x (m)`, `eccentricity ${name} y (m)`, `penetration ${name} (m)`);
  for (const { name } of given.bodies) head.push(`${name} x (m)`, `${name} y (m)`, `${name} angle (rad)`);
  const crank = given.bodies.find((body) => body.name === given.crank);
  const lines = [head.map(quoted).join(",")];
  for (let k = store.begin; k < store.end; k++) {
    const at = store.offset(k);
    const cells = [factors ? factors[k] : k * reader.interval];
    if (crank) cells.push(withinTurn((180 / Math.PI) * store.data[at + reader.of("particle_theta")[crank.particles[0]]]));
    for (const name of joints) cells.push(...reader.force(store.data, at, name), reader.forceMax(store.data, at, name));
    for (const name of driven) cells.push(reader.size(store.data, at, name), reader.forceMax(store.data, at, name));
    given.contacts.forEach((_, c) => {
      cells.push(...reader.eccentricity(store.data, at, c), store.data[at + reader.of("contact_penetration")[c]]);
    });
    for (const body of given.bodies) cells.push(...reader.point(store.data, at, body.centre).slice(0, 2), reader.turn(store.data, at, body)[0]);
    lines.push(cells.join(","));
  }
  return `${lines.join("\n")}\n`;
}

// Picture as SVG, drawn by the function that draws it on the canvas.
function svgOf(canvas, draw) {
  const { width, height } = canvas.getBoundingClientRect();
  const pen = new SvgPen(Math.round(width), Math.round(height));
  pen.fillStyle = ink.card;
  pen.fillRect(0, 0, width, height);
  draw(pen, width, height);
  return pen.document;
}

function handPng(canvas, name) {
  const copy = document.createElement("canvas");
  Object.assign(copy, { width: canvas.width, height: canvas.height });
  const pen = copy.getContext("2d");
  pen.fillStyle = ink.card;
  pen.fillRect(0, 0, copy.width, copy.height);
  pen.drawImage(canvas, 0, 0);
  copy.toBlob((blob) => hand(name, blob), "image/png");
}
