// Towards the light: the ray from a voxel of the density grid to where the light comes in. The view
// of such a march looks there, orthographic (light_march in light.h).
Ray light_ray(int3 voxel) {
  return make_ray(real3(voxel), density.direction_0, density.domain_min, density.domain_max,
                  real(0.0));
}
