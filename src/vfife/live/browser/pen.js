// Primitives: lines, discs, symbols of joints, hatched surfaces, arrows.

function trail(pen, points, closed = false) {
  pen.beginPath();
  points.forEach(([x, y], k) => {
    if (k) pen.lineTo(x, y);
    else pen.moveTo(x, y);
  });
  if (closed) pen.closePath();
}

function segment(pen, from, to) {
  trail(pen, [from, to]);
  pen.stroke();
}

function disc(pen, [x, y], radius, edge, inside, width = 1.6, alpha = 1) {
  pen.setLineDash([]);
  pen.beginPath();
  pen.arc(x, y, radius, 0, 2 * Math.PI);
  pen.fillStyle = inside;
  pen.globalAlpha = alpha;
  pen.fill();
  pen.globalAlpha = 1;
  pen.strokeStyle = edge;
  pen.lineWidth = width;
  pen.stroke();
}

function mark(pen, shape, at, colour) {
  if (shape === "square") {
    pen.fillStyle = colour;
    pen.fillRect(at[0] - 4, at[1] - 4, 8, 8);
    return;
  }
  const radius = { ring: 5, dot: 2, pin: 4.5, bearing: 6 }[shape] ?? 4;
  disc(pen, at, radius, colour, shape === "dot" ? colour : ink.paper, shape === "pin" ? 2.2 : 1.6);
}

// Draw a surface with hatched material; points: its two ends, then the same two at the depth of the hatching.
function hatched(pen, [a, b, , d]) {
  pen.strokeStyle = ink.ink;
  pen.lineWidth = 1.4;
  segment(pen, a, b);
  const deep = Math.hypot(d[0] - a[0], d[1] - a[1]) || 1;
  const count = Math.max(2, Math.round(Math.hypot(b[0] - a[0], b[1] - a[1]) / 6));
  const lean = Math.min(deep / (Math.hypot(b[0] - a[0], b[1] - a[1]) || 1), 1);
  pen.strokeStyle = ink.grey;
  pen.lineWidth = 0.9;
  pen.beginPath();
  for (let k = 0; k <= count; k++) {
    const share = k / count;
    const foot = Math.max(0, share - lean);
    const cut = share < lean ? share / lean : 1;
    pen.moveTo(a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1]));
    pen.lineTo(a[0] + foot * (b[0] - a[0]) + cut * (d[0] - a[0]), a[1] + foot * (b[1] - a[1]) + cut * (d[1] - a[1]));
  }
  pen.stroke();
}

function arrow(pen, from, to, colour, width) {
  const angle = Math.atan2(to[1] - from[1], to[0] - from[0]);
  const tip = Math.min(4 + 2.5 * width, 0.6 * Math.hypot(to[0] - from[0], to[1] - from[1]) + 2);
  pen.setLineDash([]);
  pen.strokeStyle = colour;
  pen.fillStyle = colour;
  pen.lineWidth = width;
  segment(pen, from, [to[0] - 0.7 * tip * Math.cos(angle), to[1] - 0.7 * tip * Math.sin(angle)]);
  trail(pen, [to, ...[0.42, -0.42].map((turn) => [to[0] - tip * Math.cos(angle + turn), to[1] - tip * Math.sin(angle + turn)])], true);
  pen.fill();
}
