// Where a program draws: as a fragment shader into a framebuffer, or as a compute shader into images.
// Some GPUs of data centres run fragment shaders on few of their units. A program begins with this file;
// its function draw(ivec2 at) makes the pixel `at`, row 0 is the upper one; it ends with main.glsl.
vec4 out_picture = vec4(0.0);
vec4 out_layers = vec4(0.0);

#if COMPUTE
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32f, binding = 0) uniform writeonly image2D picture_image;
layout(rgba32f, binding = 1) uniform writeonly image2D layers_image;
uniform ivec2 drawn_size;
ivec2 drawn_at() { return ivec2(gl_GlobalInvocationID.xy); }
#else
layout(location = 0) out vec4 fragment_picture;
layout(location = 1) out vec4 fragment_layers;
ivec2 drawn_at() { return ivec2(gl_FragCoord.xy); }
#endif
