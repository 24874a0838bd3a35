// The optical depth of a ray.
real4 depth_picture(IN(March) m) { return real4(color * m.optical_depth, decay(m.optical_depth).a); }
