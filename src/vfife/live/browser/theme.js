// Colours of the theme, from the style sheet. Lines also differ by dashes and forces by width, for readers who do not see colours.

const ink = {};
const DASHES = [[], [7, 3], [2, 3], [9, 3, 2, 3], [4, 2], [12, 4]];
const FONT = "system-ui, -apple-system, 'Segoe UI', Roboto, 'DejaVu Sans', sans-serif";

function readTheme() {
  const style = getComputedStyle(document.documentElement);
  const names = ["paper", "card", "ink", "grey", "faint", "accent", "warm", "ideal", "other", "spring"];
  for (const name of names) ink[name] = style.getPropertyValue(`--${name}`).trim();
  ink.bodies = [0, 1, 2, 3, 4, 5].map((k) => style.getPropertyValue(`--body-${k}`).trim());
  ink.heat = [0, 1, 2, 3].map((k) => rgb(style.getPropertyValue(`--heat-${k}`).trim()));
}

const rgb = (text) => [1, 3, 5].map((at) => Number.parseInt(text.slice(at, at + 2), 16));

// Colour of a share from 0 to 1: darker with the share on a light background, lighter on a dark one.
function heat(share) {
  const at = Math.min(Math.max(share, 0), 1) * (ink.heat.length - 1);
  const low = Math.min(Math.floor(at), ink.heat.length - 2);
  const mixed = ink.heat[low].map((part, k) => Math.round(part + (at - low) * (ink.heat[low + 1][k] - part)));
  return `rgb(${mixed.join(",")})`;
}

function setTheme(theme) {
  document.documentElement.dataset.theme = theme;
  readTheme();
}

// Clear a canvas, adapt its resolution to its box and the screen, and return its pen; null while it is hidden.
function canvasFor(element) {
  const { width, height } = element.getBoundingClientRect();
  if (width < 2 || height < 2) return null;
  const density = Math.min(window.devicePixelRatio || 1, 2);
  if (element.width !== Math.round(width * density) || element.height !== Math.round(height * density)) {
    element.width = Math.round(width * density);
    element.height = Math.round(height * density);
  }
  const pen = element.getContext("2d");
  pen.setTransform(density, 0, 0, density, 0, 0);
  pen.clearRect(0, 0, width, height);
  return { pen, width, height };
}
