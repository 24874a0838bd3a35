// The light of a ray, composited from the front or from the back.
real4 light_picture(IN(March) m) {
  real a = decay(m.optical_depth).a;
  if (constant_luminance && !adds_glow) return real4(color * a, a);
  real3 shown = m.radiance;
  if (!vector_radiance) shown = color * (m.phase * m.radiance.x);
  else if (!adds_glow) shown = color * m.phase * m.radiance;
  return real4(shown + ambient * a, a);
}
