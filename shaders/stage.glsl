// Where a program draws what `draw` makes of a pixel, row 0 first: as a fragment shader into a framebuffer;
// or as a compute shader into images, of which a data centre's GPU runs thirty times as many at once.
vec4 out_picture = vec4(0.0);
vec4 out_layers = vec4(0.0);
void draw(ivec2 at);

#if COMPUTE
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32f, binding = 0) uniform writeonly image2D picture_image;
layout(rgba32f, binding = 1) uniform writeonly image2D layers_image;
uniform ivec2 drawn_size;

ivec2 drawn_at() { return ivec2(gl_GlobalInvocationID.xy); }

void main() {
  ivec2 at = drawn_at();
  if (at.x >= drawn_size.x || at.y >= drawn_size.y) return;
  draw(at);
  imageStore(picture_image, at, out_picture);
  imageStore(layers_image, at, out_layers);
}
#else
layout(location = 0) out vec4 fragment_picture;
layout(location = 1) out vec4 fragment_layers;

ivec2 drawn_at() { return ivec2(gl_FragCoord.xy); }

void main() {
  draw(drawn_at());
  fragment_picture = out_picture;
  fragment_layers = out_layers;
}
#endif
