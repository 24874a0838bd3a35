// The values on a plane, for pages; src/march/slice.cpp draws every other picture of them.
#include "marcher.glsl"

// The picture's pixel that the tile's first one is.
uniform ivec2 tile_origin;

// A grid of luminance, or else what the density is by its function, if it has one.
vec3 shown(float value, Pixel p, float t) {
  if (own_luminance) {
    Track track = track_of(p, luminance);
    track.node = seek_node(luminance_grid, track, t);
    return sample_grid(luminance_grid, luminance_source == SOURCE_VECTOR ? 3 : 1, track, t);
  }
  if (!transfer) return vec3(value);
  Classified c = classify(value);
  return luminance_source == SOURCE_TRANSFER ? c.color : vec3(c.attenuation);
}

// The picture is R G B A, the layers are depth [world].
void draw(ivec2 at) {
  Pixel p = make_pixel(vec2(at) + vec2(tile_origin));
  Ray ray = march_ray_of(p);
  int plane = clip_first + 4 * clip_planes;  // behind the clip's
  float t = -affine(plane, p) / (affine(plane + 2, p) * p.inverse_length);
  out_picture = vec4(0.0);
  out_layers = vec4(NEVER, 0.0, 0.0, 0.0);
  if (!(t >= ray.begin && t <= ray.end)) return;
  ivec3 cell = cell_at(ray, t, density.domain_min, density.domain_max);
  Node node = sampled_node(find_node(density_grid, cell), cell);
  if (is_absent(node)) return;
  float value = node_value(node);
  if (node.kind == NODE_BRICK) value = sample_scalar(density_grid, node, position(ray, t));
  out_picture = vec4(color * shown(value, p, t), 1.0);
  out_layers.x = (t - camera_time(p)) * world_unit;
}

#include "main.glsl"
