// The end of a program that begins with stage.glsl.
void main() {
  ivec2 at = drawn_at();
#if COMPUTE
  if (at.x >= drawn_size.x || at.y >= drawn_size.y) return;
  draw(at);
  imageStore(picture_image, at, out_picture);
  imageStore(layers_image, at, out_layers);
#else
  draw(at);
  fragment_picture = out_picture;
  fragment_layers = out_layers;
#endif
}
