// The march of one ray: one loop for every sampling, flat, a turn each for a cell, a step or a voxel.
//
// A turn holds one look-up, one leave() and one set of samples and weights. What is rare (the first
// value of a ray, constant runs, empty ones) takes the same path with other numbers: llvmpipe executes
// both sides of every branch, so a rare branch costs as much as a frequent one.
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
  Node node;         // cells: of the page table, that holds the last cell
  StepWalk steps;    // uniform
  VoxelWalk voxels;  // template
};

// Every so many turns the transmittance is computed from the optical depth. In between it is a product
// that gains a rounding error with each factor; so the error does not grow along a long ray.
const int turns_of_product = 16;

Walk begin_walk(INOUT(March) m, Ray ray) {
  Walk w;
  w.node = no_node();
  if (template_sampling) w.voxels = begin_voxels(m, ray);
  else if (uniform_sampling) w.steps = begin_steps(m, ray);
  return w;
}

void end_walk(INOUT(March) m, Walk w, Ray ray) {
  if (steps_along) end_steps(m, w.steps, ray);
}

// Marches on, up to max_turns turns. A ray that stands still over so many turns would for ever, by a fault
// of the driver's arithmetic or of ours: it ends. Rays do stand still for a few turns, where they begin and
// in corners; in a step's nodes, too, which they reach one by one.
void march(INOUT(March) m, Ray ray) {
  Walk w = begin_walk(m, ray);
  int turn = 0;
  while (turn < max_turns && !m.done) {
    real last_t = m.t;
    real last_node = steps_along ? w.steps.node_end : m.t;
    for (int n = 0; n < turns_of_product && turn < max_turns && !m.done; ++n, ++turn) {
      if (template_sampling) turn_template(m, w.voxels, ray);
      else if (uniform_sampling) turn_uniform(m, w.steps, ray);
      else turn_cells(m, w.node, ray);
      if (m.t >= ray.end) m.done = true;
    }
    if (!depth_only) m.transmittance = decay(m.optical_depth).e;
    bool onward = m.t > last_t || turn >= max_turns;
    if (steps_along) onward = onward || w.steps.node_end > last_node;
    if (!onward && !m.done) {
      m.stuck = true;
      m.done = true;
    }
  }
#if !RESUMABLE
  m.stuck = m.stuck || !m.done;  // max_turns are more than any ray needs
#endif
  m.turns += turn;
  end_walk(m, w, ray);
}
