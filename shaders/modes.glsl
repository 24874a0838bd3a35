// What a mode makes of a ray. A file of modes/ has what one kind of modes shows (include/psivox/modes.h).
#include "modes/light.glsl"
#include "modes/depth.glsl"
#include "modes/value.glsl"
#include "modes/surface.glsl"

// Crosses a piece of a cell.
void cross_cell(INOUT(March) m, Node node, INOUT(Stretch) s, Ray ray) {
  if (shows == SHOWS_value) value_cell(m, s.value, s.t_end);
  else if (shows == SHOWS_surface) surface_cell(m, node, s, ray);
  else composite_stretch(m, s);
}

// Crosses a step between samples.
void cross_step(INOUT(March) m, Sample middle, Sample back, real t_back, bool run) {
  if (shows == SHOWS_value) value_step(m, back.value, t_back);
  else composite_segment(m, middle, back, t_back, t_back - m.t, run);
}

// Premultiplied radiance and opacity.
real4 picture(IN(March) m, Ray ray) {
  if (shows == SHOWS_value) return value_picture(m);
  if (shows == SHOWS_surface) return surface_picture(m, ray);
  if (shows == SHOWS_depth) return depth_picture(m);
  return light_picture(m);
}

// What a ray has collected in a region, for RayFold (src/march/carried_light.h) to join with other regions':
// radiance and transmittance, which is 0 behind a surface, or what a value is joined by.
real4 collected(IN(March) m, Ray ray) {
  if (shows == SHOWS_value) return value_collected(m, ray);
  real4 shown = picture(m, ray);
  real through = shows == SHOWS_surface ? real(1.0) - shown.w : decay(m.optical_depth).e;
  return real4(shown.x, shown.y, shown.z, through);
}

// A ray's part of the picture, or of a region.
real4 drawn(IN(March) m, Ray ray) {
  if (in_part) return collected(m, ray);
  return picture(m, ray);
}

// Distance from the camera of what the depth layer shows [world units]; NEVER where that is nothing.
real depth_of(IN(March) m, Pixel p) {
  if (m.shown_at >= NEVER || (shows == SHOWS_value && !has_value(m))) return NEVER;
  return (m.shown_at - camera_time(p)) * world_unit;
}
