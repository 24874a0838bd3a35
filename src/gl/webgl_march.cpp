#include "gl/webgl_march.h"

#include <algorithm>
#include <glm/matrix.hpp>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "base/text.h"
#include "gl/march_program.h"
#include "gl/shader_source.h"

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
  void add(const std::string& name, std::span<const glm::vec4> values) {
    WebUniform& uniform = all_.emplace_back(name, "4f");
    for (const glm::vec4& v : values) uniform.values.insert(uniform.values.end(), &v[0], &v[0] + 4);
  }

 private:
  std::vector<WebUniform>& all_;
};

WebNumbers texels_of(const BrickAtlas& atlas) {
  return {bytes_of(atlas.texels.get(), atlas.texel_count()), atlas.channels};
}

/// No texture has three channels that WebGL must support.
const char* format_of(int channels) {
  constexpr const char* of[] = {"", "R32F", "RG32F", "RGBA32F", "RGBA32F"};
  return of[channels];
}

void add_grid(const std::string& name, const BrickAtlas& atlas, const BrickAtlas* beside,
              std::vector<WebTexture>& textures) {
  const std::vector<std::uint32_t>& pages = atlas.pages.entries;
  textures.push_back({name + "_pages", "R32UI", {{bytes_of(pages.data(), pages.size())}}});
  const std::vector<float>& constants = atlas.constants;
  textures.push_back({name + "_constants",
                      format_of(atlas.channels),
                      {{bytes_of(constants.data(), constants.size()), atlas.channels}}});
  if (atlas.codes) {
    const std::string_view codes = bytes_of(atlas.codes.get(), atlas.code_count());
    textures.push_back({name + "_codes",
                        beside ? "RGBA32UI" : "RG32UI",
                        {{codes, beside ? 4 : 2}},
                        beside ? 1 + beside->channels : 1});
    return;
  }
  WebTexture texels{name + "_texels", {}, {texels_of(atlas)}};
  if (beside) texels.channels.push_back(texels_of(*beside));
  int channels = 0;
  for (const WebNumbers& some : texels.channels) channels += some.channels;
  texels.format = format_of(channels);
  textures.push_back(std::move(texels));
}

/// Names that WebGL lacks, as macros of those that it has. Its globals may not have the name of a
/// function that the language has.
Macros web_names() {
  Macros macros;
  for (const char* const name : {"samplerBuffer sampler2D", "usamplerBuffer usampler2D",
                                 "texelFetch(buffer, i) entry_of(buffer, i)", "step lattice_step"})
    macros.define(name);
  return macros;
}

ShaderSource source_of(std::string_view text) {
  ShaderSource source;
  while (!text.empty()) source.add_line(take_line(text), {});
  return source;
}

/// A text with parts of it replaced.
class Rewriter {
 public:
  Rewriter(std::string text, const std::vector<std::string>& textures)
      : text_(std::move(text)), tokens_(tokens_of(text_)), textures_(textures) {
    for (const Token& token : tokens_) ++uses_[token.text];
  }

  std::string run() {
    for (std::size_t i = 0; i < tokens_.size();) i = statement(i);
    for (std::size_t i = 0; i + 3 < tokens_.size(); ++i) {
      if (at(i) == "precise") round_exactly(i);
      if (at(i) == "entry_of") read_nothing(i);
    }
    const std::size_t brace = find(main_, "{");
    replace(tokens_[brace].end(), tokens_[brace].end(), "\n" + settings_);
    std::ranges::stable_sort(edits_, {}, &Edit::first);
    std::string result;
    std::size_t from = 0;
    for (const Edit& edit : edits_) {
      result += text_.substr(from, edit.first - from) + edit.text;
      from = edit.last;
    }
    return result + text_.substr(from);
  }

 private:
  struct Edit {
    std::size_t first, last;
    std::string text;
  };

  std::string_view at(std::size_t i) const { return tokens_[i].text; }
  std::size_t find(std::size_t i, std::string_view what) const {
    while (i + 1 < tokens_.size() && at(i) != what) ++i;
    return i;
  }
  void replace(std::size_t first, std::size_t last, const std::string& with) {
    edits_.push_back({first, last, with});
  }

  /// A statement outside functions; returns where the next begins. A global that is not constant
  /// gets its value in main, which ES demands.
  std::size_t statement(std::size_t i) {
    if (at(i)[0] == '#') return i + 1;
    if (at(i) == "uniform" && at(i + 1).ends_with("sampler2D")) {
      const std::string_view name = at(i + 2);
      const std::size_t end = find(i, ";");
      if (std::ranges::find(textures_, name) != textures_.end()) return end + 1;
      missing_[name] = at(i + 1) == "sampler2D" ? "vec4(0.0)" : "uvec4(0u)";
      replace(tokens_[i].at, tokens_[end].end(), "");
      return end + 1;
    }
    std::size_t end = i, equals = 0;
    int depth = 0;
    for (; end < tokens_.size(); ++end) {
      const std::string_view text = at(end);
      if (text == "main" && depth == 0) main_ = end;
      if (text == "(" || text == "[" || text == "{") ++depth;
      if (text == ")" || text == "]" || text == "}") --depth;
      if (depth > 0) continue;
      if (text == "=" && !equals) equals = end;
      if (text == ";" || (text == "}" && at(i) != "struct")) break;
    }
    if (equals && end < tokens_.size() && at(i) != "const") set_in_main(i, equals, end);
    return end + 1;
  }

  void set_in_main(std::size_t first, std::size_t equals, std::size_t end) {
    const std::string_view name = at(first + 1);
    if (uses_[name] == 1) return replace(tokens_[first].at, tokens_[end].end(), "");
    const std::size_t from = tokens_[equals].at;
    settings_ +=
        "  " + std::string(name) + " " + text_.substr(from, tokens_[end].end() - from) + "\n";
    replace(from, tokens_[end].at, "");
  }

  /// `precise T x = a;` as `T x = exactly(a);`.
  void round_exactly(std::size_t i) {
    const std::size_t equals = find(i, "="), end = find(i, ";");
    replace(tokens_[i].at, tokens_[i + 1].at, "");
    replace(tokens_[equals].end(), tokens_[equals].end(), " exactly(");
    replace(tokens_[end].at, tokens_[end].at, ")");
  }

  /// Puts zeros in place of a look-up in a texture that is missing: WebGL promises 16, not more.
  void read_nothing(std::size_t i) {
    const auto found = missing_.find(at(i + 2));
    if (found == missing_.end()) return;
    std::size_t end = i + 1;
    for (int depth = 1; depth > 0;) {
      ++end;
      if (at(end) == "(") ++depth;
      if (at(end) == ")") --depth;
    }
    replace(tokens_[i].at, tokens_[end].end(), found->second);
  }

  const std::string text_;
  std::vector<Token> tokens_;
  std::unordered_map<std::string_view, int> uses_;
  const std::vector<std::string>& textures_;
  std::unordered_map<std::string_view, std::string> missing_;  ///< their entries, by name
  std::vector<Edit> edits_;
  std::string settings_;  ///< of globals, in main
  std::size_t main_ = 0;
};

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
  setup.parameters.max_turns = 1 << 30;  // a page's tiles are small, its camera is anywhere
  march.textures = web_textures(atlas);
  march.textures.push_back(
      {"tables", "RGBA32F", {{bytes_of(setup.tables.data(), setup.tables.size()), 4}}});
  ProgramKey key;
  key.constants = setup.constants;
  const std::vector<std::string> names = names_in(march.textures, &WebTexture::name);
  const char* const shader = view.scene.shows(Shows::plane) ? "slice.frag" : "march.frag";
  const auto text = [&] { return webgl_text(march_source(key, shader), names); };
  march.text = text();
  key.constants.find_depth = true;
  if (has_depth) march.depth_text = text();

  Uniforms uniforms(march.uniforms);
  visit_parameters(setup.parameters, [&](const std::string& name, const auto& value) {
    uniforms.add(webgl_name(name), value);
  });
  if (setup.constants.one_interval)
    uniforms.add("interval_entries", std::span<const glm::vec4>(setup.tables)
                                         .subspan(std::size_t(setup.parameters.transfer_first), 8));
  const Medium& medium = view.medium;
  const PerGrid<const BrickAtlas*> grids = grids_of(atlas);
  const PerGrid<const Field*> fields = fields_of(medium);
  const auto add_rays = [&](int id, const std::string& name, const Field* field) {
    if (!field) return;
    const RayBundle bundle = make_ray_bundle(view.camera, *field, *medium.density);
    const glm::dvec3 origin = glm::dvec3(bundle.origin) - beside_voxels(setup.constants, id);
    march.grids.push_back({name, glm::inverse(glm::dmat3(field->world_from_index)),
                           field->world_from_index * glm::dvec4(origin, 1)});
  };
#define GRID(id, name) \
  if (grids[id]) add_rays(id, #name, fields[id]);
#include "grids.glsl"
#undef GRID
}

std::string web_display_text() {
  return webgl_text(reduced(load_shader("page.frag", "", {})), {"fine", "coarse"});
}

std::string webgl_name(const std::string& name) {
  return split(web_names().expanded(name), '\n').front();
}

std::string webgl_text(const ShaderSource& source, const std::vector<std::string>& textures) {
  const std::string text = reduced(source_of(web_names().expanded(source.text))).text;
  const auto body = [](const std::string& all) { return all.substr(all.find('\n') + 1); };
  return "#version 300 es\n" + body(load_shader("webgl.glsl", "", {}).text) +
         Rewriter(body(text), textures).run();
}

}  // namespace psivox::gl
