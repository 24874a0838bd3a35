// What a page draws when, and what the user does. The state of the canvas is in its data-state:
// moving, refining, rest, failed.

// --- coarse while it moves, then exact, some squares at a time, from the middle on ----------------
const square = 32, rest_after = 200, wanted_ms = 60;  // [pixels], [ms], [ms]
let part = 0.25, last_change = 0, changes = 0, at_work = false;

function squares() {
  const all = [];
  for (let y = 0; y < size[1]; y += square)
    for (let x = 0; x < size[0]; x += square)
      all.push([x, y, Math.min(square, size[0] - x), Math.min(square, size[1] - y)]);
  const far = ([x, y, w, h]) => Math.hypot(x + w / 2 - size[0] / 2, y + h / 2 - size[1] / 2);
  return all.sort((a, b) => far(a) - far(b));
}

async function draw_coarse() {
  coarse_size = size.map(n => Math.max(1, Math.round(part * n)));
  fine.clear();
  draw(set_march, coarse, coarse_size, [0, 0, ...coarse_size], [0.5, 0.5], false);
  show();
  const ms = await done();
  part = clamp(part * (ms > wanted_ms ? 0.8 : ms < 0.5 * wanted_ms ? 1.25 : 1), 1 / 8, 1);
}

// Returns false if the picture changes before it is complete.
async function refine(change) {
  const left = squares();
  let some = 1;
  for (let shown = 0; left.length;) {
    const now = left.splice(0, some);
    for (const pixels of now)
      samples.forEach((sample, i) => draw(set_march, fine, size, pixels, sample, i > 0));
    const ms = await done();
    if (change !== changes) return false;
    some = ms > 2 * wanted_ms ? Math.max(1, some >> 1) : ms < 0.5 * wanted_ms ? 2 * some : some;
    if (performance.now() - shown > 100 || !left.length) {
      show();
      shown = performance.now();
    }
  }
  return true;
}

const next_frame = () => new Promise(requestAnimationFrame);

async function work() {
  if (at_work) return;
  at_work = true;
  try {
    for (let drawn = -1; drawn !== changes;) {
      const change = changes;
      canvas.dataset.state = "moving";
      await next_frame();
      place_camera(set_march);
      await draw_coarse();
      canvas.dataset.frames = Number(canvas.dataset.frames ?? 0) + 1;
      canvas.dataset.first ??= Math.round(performance.now());  // [ms]
      while (change === changes && performance.now() - last_change < rest_after) await next_frame();
      if (change !== changes) continue;
      canvas.dataset.state = "refining";
      if (await refine(change)) drawn = change;
    }
    if (gl.getError()) throw Error("The browser's WebGL does not draw the picture.");
    canvas.dataset.state = "rest";
  } catch (error) {
    fail(error);
  }
  at_work = false;
}

function changed() {
  last_change = performance.now();
  ++changes;
  work();
}

function resize(wanted) {
  size = wanted;
  [canvas.width, canvas.height] = size;
  for (const target of [fine, coarse]) target?.delete();
  fine = new Target(fine_unit, size);
  coarse = new Target(coarse_unit, size);
}

// --- what the user does --------------------------------------------------------------------------
const pointers = new Map();
const middle = () => times(1 / pointers.size, [...pointers.values()].reduce(sum));
const spread = () => length([...minus(...pointers.values()), 0]);

canvas.addEventListener("pointerdown", event => {
  canvas.setPointerCapture(event.pointerId);
  pointers.set(event.pointerId, [event.clientX, event.clientY]);
});
canvas.addEventListener("pointermove", event => {
  if (!pointers.has(event.pointerId)) return;
  const before = middle(), wide = pointers.size === 2 && spread();
  pointers.set(event.pointerId, [event.clientX, event.clientY]);
  const way = minus(middle(), before);
  if (pointers.size === 2) moved.notches -= Math.log(spread() / wide) / Math.log(0.9);
  if (pointers.size === 2 || event.shiftKey || event.buttons & 6) move(way);
  else turn(way);
  changed();
});
for (const end of ["pointerup", "pointercancel"])
  canvas.addEventListener(end, event => pointers.delete(event.pointerId));
canvas.addEventListener("contextmenu", event => event.preventDefault());
canvas.addEventListener("dblclick", event => {
  const box = canvas.getBoundingClientRect();
  const point = pick([event.clientX - box.left, event.clientY - box.top].map(
    (v, i) => Math.floor(v * size[i] / [box.width, box.height][i])));
  if (!point) return;
  moved.shift = minus(point, first.target);
  changed();
});
canvas.addEventListener("wheel", event => {
  event.preventDefault();
  moved.notches -= event.deltaMode === 0 ? event.deltaY / 100 : Math.sign(event.deltaY);
  changed();
}, {passive: false});

const step = 20;  // of an arrow [pixels]
const by_arrow = (act, way) => () => { act(times(step, way)); changed(); };
const zoom = notches => () => { moved.notches += notches; changed(); };
const expose = by => () => { exposure += by; show(); };
const actions = {
  reset() {
    moved = still();
    [exposure, background] = [scene.exposure, 0];
    changed();
  },
  darker: expose(-0.25), brighter: expose(0.25),
  ground() {
    background = (background + 1) % background_choices.length;
    show();
  },
  full() { document.fullscreenElement ? document.exitFullscreen() : element("frame").requestFullscreen?.(); },
  async copy() {
    const line = command();
    element("message").textContent = line;
    await navigator.clipboard?.writeText(line).catch(() => {});
  },
};
const keys = {
  r: actions.reset, e: actions.darker, E: actions.brighter, b: actions.ground, f: actions.full,
  c: actions.copy, "+": zoom(1), "=": zoom(1), "-": zoom(-1),
};
const arrows = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1]};

document.addEventListener("keydown", event => {
  if (event.ctrlKey || event.metaKey || event.altKey || !fine) return;
  const way = arrows[event.key];
  const action = way ? by_arrow(event.shiftKey ? move : turn, way) : keys[event.key];
  if (!action) return;
  event.preventDefault();
  action();
});
document.addEventListener("fullscreenchange", () => {
  const scale = Math.min(screen.width * devicePixelRatio / scene.size[0],
                         screen.height * devicePixelRatio / scene.size[1]);
  resize(document.fullscreenElement ? scene.size.map(n => Math.round(scale * n)) : scene.size);
  changed();
});

function fail(error) {
  canvas.hidden = element("controls").hidden = element("help").hidden = true;
  element("still").hidden = false;
  element("message").textContent = error.message;
  canvas.dataset.state = "failed";
}

for (const name of ["error", "credit"]) element(name).textContent = scene[name];
element("name").textContent = scene.title;
load().then(() => {
  for (const name in actions) element(name).onclick = actions[name];
  resize(scene.size);
  canvas.hidden = element("controls").hidden = element("help").hidden = false;
  element("still").hidden = true;
  changed();
}).catch(fail);
