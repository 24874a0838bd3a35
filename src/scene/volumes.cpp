// Further volumes of a scene.

#include <algorithm>
#include <cctype>

#include "base/text.h"
#include "psivox/error.h"
#include "psivox/parameters.h"

namespace psivox {
namespace {

constexpr std::size_t most_volumes = 7;  // beside the first

/// NAME of a word NAME=VALUE; empty for other words, which belong to the file's name.
std::string_view name_in(std::string_view word) {
  const std::size_t equals = word.find('=');
  if (equals == std::string_view::npos) return {};
  const std::string_view name = word.substr(0, equals);
  const bool plain = std::ranges::all_of(name, [](char c) { return c == '-' || std::islower(c); });
  return plain ? name : std::string_view();
}

}  // namespace

Scene scene_of_volume(const Scene& scene, std::string_view text) {
  Scene volume = scene;
  volume.volumes.clear();
  std::vector<std::string> names;  // that it may have for itself
  for (const Parameter& p : parameters()) {
    if (p.of_volume == OfVolume::own || p.of_volume == OfVolume::none) set_default(volume, p);
    if (may_be_of_volume(p)) names.push_back(p.name);
  }
  while (true) {
    const std::size_t space = text.rfind(' ');
    const std::string_view word = text.substr(space + 1);  // npos + 1 is 0
    const std::string_view name = name_in(word);
    if (space == std::string_view::npos || name.empty()) break;
    if (std::ranges::count(names, name) == 0)
      throw Error(ExitCode::usage, "--and " + in_quotes(text) + ": a further volume has no " +
                                       in_quotes(name) + " of its own; it may have " +
                                       joined(names, ", "));
    set_parameter(volume, name, word.substr(name.size() + 1));
    text.remove_suffix(text.size() - space);
  }
  if (text.empty()) throw Error(ExitCode::usage, "--and needs a file");
  volume.input = text;
  return volume;
}

void check_one_volume(const Scene& scene, std::string_view who) {
  if (scene.volumes.empty()) return;
  throw Error(ExitCode::usage, std::string(who) + " is for one volume; leave out --and");
}

void validate_volumes(const Scene& scene) {
  if (scene.volumes.empty()) return;
  const auto fail = [](const std::string& message) { throw Error(ExitCode::usage, message); };
  for (const std::string& volume : scene.volumes) scene_of_volume(scene, volume);
  if (scene.volumes.size() > most_volumes) fail("--and draws at most 7 volumes beside the first");
  if (scene.mode != Mode::alpha) fail("--and is for --mode alpha");
  if (scene.has_function())
    fail(
        "--and: the attenuation of several volumes is their value; leave out --transfer-function, "
        "--colormap, --range and --opacity, or give --look smoke");
  if (scene.resolved_integrator() != Integrator::cell_exact ||
      scene.resolved_sampling() != Sampling::cells || scene.filter != Filter::exact)
    fail("--and draws exact cells; leave out --step, --sampling, --integrator and --filter");
}

}  // namespace psivox
