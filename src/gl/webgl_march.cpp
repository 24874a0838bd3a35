#include "gl/webgl_march.h"

#include <glm/matrix.hpp>
#include <span>

#include "gl/march_source.h"
#include "gl/webgl_source.h"

namespace psivox::gl {
namespace {

template <typename T>
std::string_view bytes_of(const T* first, std::size_t count) {
  return {reinterpret_cast<const char*>(first), count * sizeof(T)};
}

class Uniforms {
 public:
  explicit Uniforms(std::vector<WebUniform>& all) : all_(all) {}

  void add(const std::string& name, int v) { all_.push_back({name, "1i", {double(v)}}); }
  void add(const std::string& name, double v) { all_.push_back({name, "1f", {v}}); }
  template <int n>
  void add(const std::string& name, const glm::vec<n, double>& v) {
    all_.push_back({name, std::to_string(n) + "f", {&v[0], &v[0] + n}});
  }
  void add(const std::string& name, const glm::ivec3& v) {
    all_.push_back({name, "3i", {&v[0], &v[0] + 3}});
  }
  void add(const std::string& name, const glsl::Grid& grid) {
#define PARAMETER(type, member) add(name + "." #member, grid.member);
#include "grid_parameters.glsl"
#undef PARAMETER
  }
  void add(const MarchParameters& parameters) {
#define PARAMETER(type, name) add(webgl_name("given." #name), parameters.name);
#include "march_parameters.glsl"
#undef PARAMETER
  }
  void add(const std::string& name, std::span<const glm::vec4> values) {
    WebUniform& uniform = all_.emplace_back(name, "4f");
    for (const glm::vec4& v : values) uniform.values.insert(uniform.values.end(), &v[0], &v[0] + 4);
  }

 private:
  std::vector<WebUniform>& all_;
};

WebNumbers texels_of(const BrickAtlas& atlas) {
  if (atlas.texel == TexelType::float32)
    return {bytes_of(atlas.texels32.get(), atlas.texel_count()), 4, atlas.channels};
  return {bytes_of(atlas.texels16.get(), atlas.texel_count()), 2, atlas.channels};
}

/// No texture has three channels that WebGL must support.
std::string format_of(int channels, int size) {
  constexpr const char* of[] = {"", "R", "RG", "RGBA", "RGBA"};
  return of[channels] + std::to_string(8 * size) + "F";
}

void add_grid(const std::string& name, const BrickAtlas& atlas, const BrickAtlas* beside,
              std::vector<WebTexture>& textures) {
  const std::vector<std::uint32_t>& pages = atlas.pages.entries;
  textures.push_back({name + "_pages", "R32UI", {{bytes_of(pages.data(), pages.size())}}});
  const std::vector<float>& constants = atlas.constants;
  textures.push_back({name + "_constants",
                      format_of(atlas.channels, 4),
                      {{bytes_of(constants.data(), constants.size()), 4, atlas.channels}}});
  if (atlas.codes) {
    const std::string_view codes = bytes_of(atlas.codes.get(), atlas.code_count());
    textures.push_back({name + "_codes",
                        beside ? "RGBA32UI" : "RG32UI",
                        {{codes, 4, beside ? 4 : 2}},
                        beside ? 1 + beside->channels : 1});
    return;
  }
  WebTexture texels{name + "_texels", {}, {texels_of(atlas)}};
  if (beside) texels.channels.push_back(texels_of(*beside));
  int channels = 0;
  for (const WebNumbers& some : texels.channels) channels += some.channels;
  texels.format = format_of(channels, texels.channels[0].size);
  textures.push_back(std::move(texels));
}

const Field* field_of(const std::shared_ptr<const Field>& field) { return field.get(); }
const Field* field_of(const std::vector<Medium>&) { return nullptr; }  // the density's rays

}  // namespace

std::vector<WebTexture> web_textures(const MediumAtlas& atlas) {
  std::vector<WebTexture> textures;
  const PerGrid<const BrickAtlas*> grids = grids_of(atlas);
  const BrickAtlas* const beside = atlas.paired ? grids[luminance_grid] : nullptr;
#define GRID(id, name)                                \
  if (grids[id] && !(beside && id == luminance_grid)) \
    add_grid(#name, *grids[id], id == density_grid ? beside : nullptr, textures);
#include "grids.glsl"
#undef GRID
  return textures;
}

void make_web_march(const View& view, const MediumAtlas& atlas, const BrickSteps& steps,
                    bool has_depth, WebMarch& march) {
  march.setup = make_march_setup(view, atlas, {.brick_steps = steps});
  MarchSetup& setup = march.setup;
  setup.constants.passes_octants = false;  // see there
  setup.parameters.max_turns = 1 << 30;    // a page's tiles are small, its camera is anywhere
  march.textures = web_textures(atlas);
  march.textures.push_back(
      {"tables", "RGBA32F", {{bytes_of(setup.tables.data(), setup.tables.size()), 4, 4}}});
  ProgramKey key;
  key.constants = setup.constants;
  std::vector<std::string> names;
  for (const WebTexture& texture : march.textures) names.push_back(texture.name);
  const char* const shader = view.scene.shows(Shows::plane) ? "slice.frag" : "march.frag";
  const auto text = [&] { return webgl_text(march_source(key, shader, false), names); };
  march.text = text();
  key.constants.find_depth = true;
  if (has_depth) march.depth_text = text();

  Uniforms uniforms(march.uniforms);
  uniforms.add(setup.parameters);
  if (setup.constants.one_interval)
    uniforms.add("interval_entries", std::span<const glm::vec4>(setup.tables)
                                         .subspan(std::size_t(setup.parameters.transfer_first), 8));
  const Medium& medium = view.medium;
  const PerGrid<const BrickAtlas*> grids = grids_of(atlas);
  const auto add_rays = [&](const std::string& name, const Field* field) {
    if (!field) return;
    const RayBundle bundle = make_ray_bundle(view.camera, *field, *medium.density);
    march.grids.push_back({name, glm::inverse(glm::dmat3(field->world_from_index)),
                           field->world_from_index * glm::dvec4(bundle.origin, 1)});
  };
#define GRID(id, name) \
  if (grids[id]) add_rays(#name, field_of(medium.name));
#include "grids.glsl"
#undef GRID
}

std::string web_display_text() {
  return webgl_text(reduced(load_shader("page.frag", "", {})), {"fine", "coarse"});
}

}  // namespace psivox::gl
