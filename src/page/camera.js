// The camera of a page that turns. src/page/page.cpp writes camera.js, march.js and page.js into the
// page, as one script.
"use strict";
const element = id => document.getElementById(id);
const scene = JSON.parse(element("scene").textContent);
const canvas = element("view");

// --- vectors -------------------------------------------------------------------------------------
const sum = (a, b) => a.map((v, i) => v + b[i]);
const times = (s, a) => a.map(v => s * v);
const minus = (a, b) => a.map((v, i) => v - b[i]);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const length = a => Math.sqrt(dot(a, a));
const clamp = (v, least, most) => Math.min(Math.max(v, least), most);
const rotated = (v, axis, angle) => {  // Rodrigues
  const along = times(dot(v, axis) * (1 - Math.cos(angle)), axis);
  return sum(sum(times(Math.cos(angle), v), times(Math.sin(angle), cross(axis, v))), along);
};

// --- the camera: the first one and how it was moved, so that the way back leads to the same -------
const first = scene.camera;
const first_depth = length(minus(first.target, first.position));
const still = () => ({turn: [0, 0], shift: [0, 0, 0], notches: 0});  // turn: of 180 degrees
let moved = still();

function camera() {
  const angles = times(Math.PI, moved.turn);
  const elevation = Math.asin(clamp(dot(first.forward, first.axis), -1, 1));
  const pitch = clamp(elevation - angles[1], -Math.PI / 2, Math.PI / 2) - elevation;
  const turned = v => moved.turn[0] || moved.turn[1]
    ? rotated(rotated(v, first.right, pitch), first.axis, -angles[0]) : v;
  const zoom = 0.9 ** moved.notches, forward = turned(first.forward);
  const target = sum(first.target, moved.shift);
  const depth = first.orthographic ? first_depth : zoom * first_depth;
  return {
    target, depth, forward, right: turned(first.right), up: turned(first.up),
    position: minus(target, times(depth, forward)),
    half_width: first.orthographic ? zoom * first.half_width : first.half_width,
    half_height: (first.orthographic ? zoom : 1) * first.half_width * scene.size[1] / scene.size[0],
  };
}

// Half a turn is the picture's height. What is added is a multiple of 2^-30, so that sums are exact.
function turn(pixels) {
  moved.turn = sum(moved.turn, pixels.map(v => Math.round(v / canvas.clientHeight * 2 ** 30) / 2 ** 30));
}

function move(pixels) {  // the plane through the target follows the pointer
  const c = camera(), width = first.orthographic ? c.half_width : c.half_width * c.depth;
  const pixel = 2 * width / canvas.clientWidth;
  moved.shift = sum(moved.shift, sum(times(pixel * pixels[1], c.up), times(-pixel * pixels[0], c.right)));
}

const rounded = (v, unit) => {  // as the window rounds (view/navigation.h)
  const digits = 10 ** Math.ceil(-Math.log10(unit));
  return Math.round(v * digits) / digits + 0;
};

function command() {
  const c = camera(), unit = 1e-6 * c.depth, place = v => v.map(x => rounded(x, unit)).join(",");
  const pole = Math.abs(dot(c.forward, first.axis)) > 0.999;
  let line = `${contrast() === 1 ? scene.command : scene.contrast.command} --camera-position=${place(c.position)} --camera-target=${place(c.target)}` +
    ` --camera-up=${(pole ? c.up : first.axis).map(x => rounded(x, 1e-6)).join(",")}`;
  if (first.orthographic)
    line += ` --ortho-width=${rounded(2 * c.half_width * first.zoom, 1e-6 * c.half_width)}`;
  if (exposure) line += ` --exposure=${exposure}`;
  if (background || scene.background) line += ` --background=${background_choices[background].join(",")}`;
  return line;
}
