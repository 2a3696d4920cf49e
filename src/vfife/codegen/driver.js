// What drives a straight-line step, and the functions of time that it asks for.

// count steps from step n0. The whole step starts a run and takes every step that the lean one leaves; extremes are the caller's to set back.
function advance(S, T, n0, count) {
  for (let n = n0; n < n0 + count; n++) {
    functions(S, T, n);
    if (n === 0 || !lean(S, n)) whole(S, n);
  }
}

// Value and two derivatives of a table, as kernels/polynomial.py has them.
function polynomial(T, start, time) {
  let pieces = T[start], first = start + 1;
  if (pieces < 0) {
    pieces = -pieces;
    const period = T[first];
    first += 1;
    time = time - ((time / period - 0.5 + 6755399441055744) - 6755399441055744) * period;
  }
  let low = 0, high = pieces - 1;
  while (low < high) {
    const middle = Math.floor((low + high + 1) / 2);
    if (T[first + middle] <= time) low = middle;
    else high = middle - 1;
  }
  const x = time - T[first + low], c = first + pieces + 7 * low;
  let value = 0, rate = 0, half = 0;
  for (let k = 6; k >= 0; k--) {
    half = half * x + rate;
    rate = rate * x + value;
    value = value * x + T[c + k];
  }
  return [value, rate, 2 * half];
}
