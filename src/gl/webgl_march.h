#pragma once

#include <glm/mat3x3.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "gl/shader_source.h"
#include "march/march_parameters.h"

namespace psivox::gl {

/// A uniform by the suffix of the function that sets it: `3f`, `1i`.
struct WebUniform {
  std::string name, kind;
  std::vector<double> values;
};

/// Some channels of a texture's entries: numbers of 4 bytes.
struct WebNumbers {
  std::string_view bytes;
  int channels = 1;
};

/// Entries for texture buffers, one after the other.
struct WebTexture {
  std::string name, format;  ///< `RGBA32F`
  std::vector<WebNumbers> channels;
  int code_channels = 0;  ///< of bricks in codes (CodeWidth); 0: these are no codes
};

/// How a camera's rays come into a grid's voxels (RayBundle).
struct WebGrid {
  std::string name;
  glm::dmat3 linear;  ///< index from world
  glm::dvec3 origin;  ///< of the point that coordinates are relative to [world]
};

/// march.frag for WebGL 2, with all that it reads.
struct WebMarch {
  MarchSetup setup;
  std::string text, depth_text;  ///< the second finds the depth too; empty: there is none
  std::vector<WebUniform> uniforms;
  std::vector<WebTexture> textures;  ///< they point to the setup's and the atlas's numbers
  std::vector<WebGrid> grids;
};

/// The march of a view, with exact filtering. The atlas must stay as long as the result, which is
/// not to be moved.
void make_web_march(const View& view, const MediumAtlas& atlas, const BrickSteps& steps,
                    bool has_depth, WebMarch& march);

/// The atlas's textures alone. Those of the luminance come with its light.
std::vector<WebTexture> web_textures(const MediumAtlas& atlas);

/// page.frag for WebGL 2.
std::string web_display_text();

/// The text of a fragment shader in GLSL ES 3.00, which WebGL 2 compiles: its macros replaced, its
/// texture buffers textures of shaders/webgl.glsl, its globals set by main. `textures`: those that
/// there are; others have entries of 0.
std::string webgl_text(const ShaderSource& source, const std::vector<std::string>& textures);

/// The name of a uniform there.
std::string webgl_name(const std::string& name);

}  // namespace psivox::gl
