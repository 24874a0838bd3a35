// The march of one ray: one loop for every sampling, flat, a turn each for a cell, a step or a voxel.
//
// A turn holds one look-up, one leave() and one set of samples and weights. What is rare (the first
// value of a ray, constant runs, empty ones) takes the same path with other numbers: llvmpipe executes
// both sides of every branch, so a rare branch costs as much as a frequent one.
//
// A function that a turn calls has one exit, but for returns that constants decide. If it returns in its
// middle, a GPU's compiler takes registers of their own for all that it makes (docs/gpu.md).
#include "pixel.glsl"
#include "ray_state.glsl"
#include "composite.glsl"
#include "stretch.glsl"
#include "modes.glsl"
#include "turn_cells.glsl"
#include "turn_uniform.glsl"
#include "turn_template.glsl"

// What a walk remembers between turns; each sampling reads its own part.
struct Walk {
  CellWalk cells;
  StepWalk steps;    // uniform
  VoxelWalk voxels;  // template
};

// Every so many turns the transmittance is computed from the optical depth. In between it is a product
// that gains a rounding error with each factor; so the error does not grow along a long ray.
const int turns_of_product = 16;

Walk begin_walk(INOUT(March) m, Ray ray) {
  Walk w;
  w.cells = begin_cells();
  if (template_sampling) w.voxels = begin_voxels(m, ray);
  else if (uniform_sampling) w.steps = begin_steps(m, ray);
  return w;
}

void end_walk(INOUT(March) m, Walk w, Ray ray) {
  if (steps_along) end_steps(m, w.steps, ray);
}

// How far the walk is: grows from turn to turn, but for a few where the ray begins and in corners.
real reached(IN(March) m, IN(Walk) w) {
  if (steps_along) return m.t + w.steps.node_end;  // it reaches a step's nodes one by one
  return m.t;
}

// Marches on, up to max_turns turns or some more, a number of turns_of_product. A ray that stands still
// over so many turns would for ever, by a fault of the driver's arithmetic or of ours: it ends.
void march(INOUT(March) m, Ray ray) {
  Walk w = begin_walk(m, ray);
  bool ended = m.done;  // in a pass before
  for (int turn = 0; turn < max_turns && !m.done; turn += turns_of_product) {
    real last = reached(m, w);
    for (int n = 0; n < turns_of_product && !m.done; ++n) {
      if (template_sampling) turn_template(m, w.voxels, ray);
      else if (uniform_sampling) turn_uniform(m, w.steps, ray);
      else turn_cells(m, w.cells, ray);
      if (m.t >= ray.end) m.done = true;
    }
    if (shows == SHOWS_light && !depth_only) m.transmittance = decay(m.optical_depth).e;
    if (!m.done && !(reached(m, w) > last)) {  // so that NaN ends, too
      m.stuck = true;
      m.done = true;
    }
  }
#if !RESUMABLE
  m.stuck = m.stuck || !m.done;  // max_turns are more than any ray needs
#endif
  if (!ended) end_walk(m, w, ray);
}
