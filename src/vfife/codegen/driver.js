// What drives a straight-line step, and the functions of time that it asks for.

// count steps from step n0. The whole step starts a run and takes every step that the lean one leaves; where something began, ended or changed
// its regime, the step is taken again in so many parts. A share of a step comes right after the start. Extremes are the caller's to set back.
// It returns the number of the next step: n0 + count, or less where a place is no longer a finite number, which is seen within a thousand steps.
function advance(S, T, n0, count, parts = 8, share = 0) {
  for (let n = n0; n < n0 + count; n++) {
    functions(S, T, n);
    if (n === 0 || !lean(S, n)) {
      const before = parts > 1 ? S.slice() : null;
      whole(S, n);
      if (n > 0 && parts > 1 && S[EVENT] > 0) again(S, before, T, n, parts);
      if (n === 0 && share > 0) displace(S, T, share);
    }
    if ((n + 1) % 1000 === 0 && !PLACES.every((row) => Number.isFinite(S[row]))) return n + 1;
  }
  return n0 + count;
}

// Step n once more, from the state before it, as so many smaller ones.
function again(S, before, T, n, parts) {
  S.set(before);
  const dt = S[STEP], shift = S[SHIFT];
  functions(S, T, n - 1);
  resize(S, dt / parts, shift * parts, 1);
  for (let i = (n - 1) * parts + 1; i <= n * parts; i++) {
    functions(S, T, i);
    whole(S, i);
  }
  resize(S, dt, shift, 0);
}

// After the start, a first step of a share of one.
function displace(S, T, share) {
  const dt = S[STEP];
  resize(S, share * dt, 0, 0);
  functions(S, T, 1);
  whole(S, 1);
  resize(S, dt, share, 0);
}

// Value, two derivatives and kinks of a table, as kernels/polynomial.py has them.
function polynomial(T, start, time) {
  let pieces = T[start], first = start + 1, kinks = 0;
  if (pieces < 0) {
    pieces = -pieces;
    const period = T[first];
    const turns = (time / period - 0.5 + 6755399441055744) - 6755399441055744;
    time = time - turns * period;
    kinks = turns * T[first + 1];
    first += 2;
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
  return [value, rate, 2 * half, kinks + T[first + 8 * pieces + low]];
}
