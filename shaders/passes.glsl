// State between passes, where rays may need several.
#if RESUMABLE
// Rays that need more turns than a pass may take go on in the next one, from the state they left.
uniform bool first_pass;
layout(binding = 0) uniform isampler2D state_in[4];
#if COMPUTE
layout(rgba32i, binding = 2) uniform writeonly iimage2D state_images[4];
#define save_state(i, at, state) imageStore(state_images[i], at, state)
#else
layout(location = 2) out ivec4 out_state[4];
#define save_state(i, at, state) out_state[i] = state
#endif

void load_march(INOUT(March) m, ivec2 at) {
  ivec4 a = texelFetch(state_in[0], at, 0);
  ivec4 b = texelFetch(state_in[1], at, 0);
  ivec4 c = texelFetch(state_in[2], at, 0);
  ivec4 d = texelFetch(state_in[3], at, 0);
  m.transmittance = intBitsToFloat(a.x);
  m.front.value = intBitsToFloat(a.y);
  m.optical_depth = intBitsToFloat(a.z);
  m.lost = intBitsToFloat(a.w);
  m.cell = b.xyz;
  if (template_sampling) m.lattice = b.w;
  m.radiance = intBitsToFloat(c.xyz);
  if (keeps_depth) m.shown_at = intBitsToFloat(c.w);
  if (count_steps) {
    m.steps = d.x;
    m.samples = d.y;
  }
  m.stuck = (d.z & 2) != 0;
  m.done = (d.z & 1) != 0;
  m.t = intBitsToFloat(d.w);
  m.known = m.front.value > UNKNOWN && !own_luminance && !has_emission && !with_gradient;
  m.front = with_value(m, m.front, Sample(m.front.value, real(0.0)));
  if (end_corrections) {  // under uniform, which finds its cell by t
    m.step_error = intBitsToFloat(b.x);
    m.front.slope = intBitsToFloat(b.y);
    m.known = false;  // the luminance's slope is to be found again
  }
}

void save_march(IN(March) m, ivec2 at) {
  save_state(0, at, ivec4(floatBitsToInt(m.transmittance), floatBitsToInt(m.front.value),
                          floatBitsToInt(m.optical_depth), floatBitsToInt(m.lost)));
  ivec4 place = ivec4(m.cell, m.lattice);
  if (end_corrections) place.xy = floatBitsToInt(vec2(m.step_error, m.front.slope));
  save_state(1, at, place);
  save_state(2, at, ivec4(floatBitsToInt(m.radiance), floatBitsToInt(m.shown_at)));
  // of which TileTarget::draw_passes reads the last two
  save_state(3, at, ivec4(m.steps, m.samples, (m.stuck ? 2 : 0) + (m.done ? 1 : 0), floatBitsToInt(m.t)));
}
#endif
