#include "psivox/page.h"

#include <filesystem>
#include <nlohmann/json.hpp>

#include "app/command_text.h"
#include "base/text.h"
#include "image/formats.h"
#include "march/film.h"
#include "page/page_parts.h"
#include "plan/plan.h"
#include "psivox/open.h"
#include "psivox/parameters.h"
#include "psivox/picture_file.h"
#include "scene/cuts.h"

namespace psivox {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr double megabyte = 1e6;

Json json_of(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

void check_size(double bytes, const PageOptions& options) {
  if (bytes <= options.limit_mb * megabyte) return;
  throw Error(ExitCode::usage, formatted("the page takes %.1f MB or more, above --page-limit %g; "
                                         "--tolerance, --lod 1 or --clip "
                                         "makes it smaller",
                                         bytes / megabyte, options.limit_mb));
}

/// The picture as a PNG of base64, over black if there is no background. It has no metadata: these
/// name folders.
std::string png_of(Image image, const Scene& scene) {
  add_background(image, scene.background ? scene.background->color : glm::dvec3(0), {});
  image.metadata.clear();
  return base64(image_io::png_bytes(image, {.display = display_of(scene)}));
}

/// The command that draws the picture, but for what the page changes: camera, exposure, background.
/// Lights that follow the camera stay where they are.
std::string command_of(Scene scene, const Camera& camera) {
  for (DirectionalLight& light : scene.lights) {
    if (light.of_camera) light.direction = from_camera(camera, light.direction);
    light.of_camera = false;
  }
  scene.camera_position.reset();
  scene.camera_target.reset();
  scene.camera_up.reset();
  scene.azimuth = scene.elevation = 0;
  scene.ortho_width.reset();
  scene.exposure = Scene{}.exposure;
  scene.background.reset();
  return render_command_line(scene, "picture.png");
}

/// "estimated error RMS 3.1e-04, tolerance 0.001"; empty where nothing is known of it, and of a
/// slice, which has none.
std::string error_text(const Drawn& drawn) {
  std::string text;
  if (drawn.view.scene.shows(Shows::plane)) return text;
  if (drawn.plan && drawn.plan->rays > 0)
    text = formatted("estimated error RMS %.1e", drawn.plan->chosen.rms);
  if (drawn.view.scene.tolerance)
    text += (text.empty() ? "tolerance " : ", tolerance ") +
            formatted("%g", *drawn.view.scene.tolerance);
  return text;
}

Json camera_json(const View& view) {
  const Camera& camera = view.camera;
  return {{"position", json_of(camera.position)},
          {"target", json_of(camera.target)},
          {"right", json_of(camera.right)},
          {"up", json_of(camera.up)},
          {"forward", json_of(camera.forward)},
          {"axis", json_of(glm::normalize(camera.camera_up))},
          {"orthographic", camera.orthographic},
          {"half_width", camera.half_width},
          {"zoom", view.scene.zoom}};
}

/// What the script needs to march, but for the textures' numbers.
Json march_json(const View& view, const gl::WebMarch& march) {
  const Box domain = view.medium.density->domain();
  const glm::dvec3 middle = 0.5 * (glm::dvec3(domain.min) + glm::dvec3(domain.max));
  Json json = {{"unit", march.setup.parameters.world_unit},
               {"middle", json_of(view.medium.density->world_from_index * glm::dvec4(middle, 1))},
               {"clip_first", march.setup.parameters.clip_first}};
  for (const gl::WebGrid& grid : march.grids)
    json["grids"].push_back(
        {{"name", grid.name},
         {"columns", {json_of(grid.linear[0]), json_of(grid.linear[1]), json_of(grid.linear[2])}},
         {"origin", json_of(grid.origin)}});
  json["clip"] = Json::array();
  for (const HalfSpace& half : cuts_of(view.scene))
    json["clip"].push_back({{"normal", json_of(half.normal)}, {"offset", half.offset}});
  for (const gl::WebUniform& uniform : march.uniforms)
    json["uniforms"].push_back({uniform.name, uniform.kind, uniform.values});
  for (const gl::WebTexture& texture : march.textures) {
    Json channels = Json::array();
    for (const gl::WebNumbers& some : texture.channels) channels.push_back(some.channels);
    json["textures"].push_back({{"name", texture.name},
                                {"format", texture.format},
                                {"channels", channels},
                                {"code_channels", texture.code_channels}});
  }
  for (int i = 0; i < view.scene.pixel_samples; ++i) {
    const glm::dvec2 place = pixel_sample(i, view.scene.pixel_samples);
    json["samples"].push_back({place.x, place.y});
  }
  return json;
}

/// How smoke is drawn before a bright background, as a look chooses it (dark_contrast): a factor of
/// its light, and the command. Null: it is no smoke, or is dark already.
Json contrast_json(Scene scene, const View& view) {
  if (!scene.lit() || scene.has_function() || !scene.luminance_grid.empty() ||
      !scene.temperature_grid.empty() || !view.medium.emission.empty() ||
      !view.medium.others.empty() || has_bright_background(scene))
    return {};
  scene.albedo *= dark_contrast;
  scene.luminance = scene.resolved_luminance() * dark_contrast;
  return {{"factor", dark_contrast}, {"command", command_of(scene, view.camera)}};
}

Json scene_json(const View& view, const Drawn& drawn, const gl::WebMarch& march,
                const PageOptions& options) {
  const Scene& scene = view.scene;
  return {{"title", fs::path(scene.input).filename().string()},
          {"error", error_text(drawn)},
          {"credit", options.credit},
          {"version", PSIVOX_VERSION},
          {"command", command_of(drawn.view.scene, view.camera)},
          {"size", {scene.resolution.x, scene.resolution.y}},
          {"exposure", scene.exposure.value_or(0)},
          {"tone_map", int(scene.tone_map)},
          {"background", scene.background ? json_of(scene.background->color) : Json()},
          {"contrast", contrast_json(drawn.view.scene, view)},
          {"camera", camera_json(view)},
          {"march", march_json(view, march)}};
}

/// An element that the script reads by its id. No text of ours ends it: JSON's `<` is escaped.
std::string element(const std::string& id, const std::string& type, const std::string& text) {
  return "<script type=\"" + type + "\" id=\"" + id + "\">" + text + "</script>\n";
}

/// What a slice shows, in place of the view's medium, and its atlas; unset in other modes.
std::optional<MediumAtlas> slice_atlas(View& view) {
  if (!view.scene.shows(Shows::plane)) return {};
  view = slice_view(std::move(view));
  view.scene.texel = TexelType::float32;
  return build_medium_atlas(view);
}

}  // namespace

std::string filled_page(const std::map<std::string, std::string>& files,
                        const std::vector<std::string>& scripts,
                        const std::vector<std::pair<std::string, std::string>>& texts) {
  std::string elements, sources;
  for (const std::string& script : scripts) {
    const std::string& hex = files.at(script + ".sha256");
    std::string hash;
    for (std::size_t i = 0; i < hex.size(); i += 2)
      hash += static_cast<char>(std::stoi(hex.substr(i, 2), nullptr, 16));
    sources += " 'sha256-" + base64(hash) + "'";
    elements += "<script>" + files.at(script) + "</script>\n";
  }
  std::string page = files.at("page.html");
  const auto fill = [&](const std::string& mark, const std::string& text) {
    page.replace(page.find(mark), mark.size(), text);
  };
  fill("@SCRIPTS@", elements);
  for (const auto& [mark, text] : texts) fill(mark, text);
  fill("@POLICY@",
       "default-src 'none'; img-src data:; style-src 'unsafe-inline'; base-uri 'none'; "
       "form-action 'none'; script-src" +
           sources);
  return page;
}

bool is_page_name(const std::string& path) {
  const std::string extension = lower_case(fs::path(path).extension().string());
  return extension == ".html" || extension == ".htm";
}

std::string page_obstacle(const Scene& scene) {
  const auto no = [](const std::string& what) { return "a page (.html) has no " + what; };
  if (scene.filter == Filter::hardware) return no("--filter hardware");
  if (scene.resolved_sampling() == Sampling::template_) return no("--sampling template");
  if (!scene.holdout.empty()) return no("--holdout");
  if (scene.uses_ocio()) return no("--ocio; leave it out");
  if (scene.background && scene.background->environment) return no("--background environment");
  for (const char* drawn : {"color-bar", "scale-bar", "axes", "box", "title"})
    if (!has_default(scene, *find_parameter(drawn))) return no("--" + std::string(drawn));
  if (scene.renderer == RendererKind::reference) return no("--renderer reference");
  return {};
}

void check_page(Session& session, const Scene& scene, const PageOptions& options) {
  if (const std::string obstacle = page_obstacle(scene); !obstacle.empty())
    throw Error(ExitCode::usage, obstacle);
  if (scene.shows(Shows::plane)) return;  // its bricks are few
  double bytes = 0, least = 0;
  const auto textures = [&](const Scene& of) { return gl::web_textures(session.atlas(of)); };
  for (const gl::WebTexture& texture : textures(scene))
    for (const gl::WebNumbers& some : texture.channels) bytes += double(some.bytes.size());
  if (bytes < options.limit_mb * megabyte) return;  // it will be smaller
  View view = session.view();
  view.scene = scene;
  if (scene.tolerance && may_be_coded(view)) view.scene.texel = TexelType::code7;
  for (const gl::WebTexture& texture : textures(view.scene))
    for (const std::string& text : packed(texture)) least += double(text.size());
  check_size(least, options);
}

std::string page_text(Session& session, const Drawn& drawn, const PageOptions& options) {
  const PlannedMarch* const planned = drawn.plan ? drawn.plan->march.get() : nullptr;
  View view = planned ? planned->view : drawn.view;
  view.scene.background = drawn.view.scene.background;
  if (!view.scene.exposure) view.scene.exposure = auto_exposure(drawn.image, view.scene.tone_map);
  gl::WebMarch march;
  const std::optional<MediumAtlas> sliced = slice_atlas(view);
  const MediumAtlas& atlas =
      sliced ? *sliced : session.atlas(view.scene, planned ? planned->code_widths : nullptr);
  make_web_march(view, atlas, planned ? planned->brick_steps : nullptr,
                 layer_obstacle("depth", view.scene).empty(), march);
  std::string data =
      element("scene", "application/json",
              without_tags(scene_json(view, drawn, march, options)
                               .dump(-1, ' ', false, Json::error_handler_t::replace)));
  data += element("march", "x-shader/x-fragment", march.text);
  data += element("depth", "x-shader/x-fragment", march.depth_text);
  data += element("display", "x-shader/x-fragment", gl::web_display_text());
  for (const gl::WebTexture& texture : march.textures) {
    const std::vector<std::string> texts = packed(texture);
    for (std::size_t i = 0; i < texts.size(); ++i)
      data += element(texture.name + "-" + std::to_string(i), "text/plain", texts[i]);
  }
  const std::string page =
      filled_page(turning_page_files(), {"camera.js", "march.js", "page.js"},
                  {{"@DATA@", data},
                   {"@PICTURE@", png_of(drawn.image, view.scene)},
                   {"@TITLE@", html_text(fs::path(view.scene.input).filename().string())}});
  check_size(double(page.size()), options);
  return page;
}

}  // namespace psivox
