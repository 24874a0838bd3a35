#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "psivox/scene.h"

namespace psivox {

/// The range of a parameter's number, or of each component of its vector.
struct Range {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  bool min_open = false;  ///< min itself is not allowed
  bool max_open = false;

  bool contains(double value) const;
  std::string text() const;  ///< " from 0 to 1", " above 0"; empty if it has no limits
};

/// The member of Scene that holds a parameter. Its type decides how text is read.
using SceneMember =
    std::variant<std::string Scene::*, bool Scene::*, int Scene::*, std::uint64_t Scene::*,
                 double Scene::*, std::optional<double> Scene::*, glm::dvec3 Scene::*,
                 std::optional<glm::dvec3> Scene::*, std::optional<Background> Scene::*,
                 glm::ivec2 Scene::*, std::optional<MapRange> Scene::*,
                 std::optional<OpacityCurve> Scene::*, std::vector<DirectionalLight> Scene::*,
                 std::vector<std::string> Scene::*, std::optional<WorldBox> Scene::*,
                 std::optional<Plane> Scene::*, std::optional<Colormap> Scene::*, Mode Scene::*,
                 Classification Scene::*, Centering Scene::*, std::optional<Integrator> Scene::*,
                 std::optional<Sampling> Scene::*, Filter Scene::*, TexelType Scene::*,
                 RendererKind Scene::*, Projection Scene::*, UpAxis Scene::*, LightQuality Scene::*,
                 ToneMap Scene::*, EmissionColor Scene::*, DepthKind Scene::*, ValueScale Scene::*,
                 std::optional<std::string> Scene::*, std::vector<ShownSurface> Scene::*>;

/// The sections of --help and of the viewer's panel, in their order.
enum class ParameterGroup { input, output, look, light, camera, accuracy, machine };

/// "Accuracy".
std::string group_name(ParameterGroup group);

/// The demand of `--tolerance E` on a parameter. This is the one definition of which parameters a
/// tolerance excludes and which must be unset for `default_tolerance` to apply.
enum class UnderTolerance {
  free,      ///< it may have any value
  chosen,    ///< part of the method: sampling, rule and step. The tolerance chooses it
  unchanged  ///< it must have its default; the error estimate holds for no other value
};

/// What a further volume (`--and`) has for a parameter.
enum class OfVolume {
  scenes,         ///< what the scene has
  own_or_scenes,  ///< its own value, else the scene's
  own,            ///< its own value, else the default
  none            ///< the default
};

/// One row of the table of parameters: all that the command line, --help, JSON, image metadata and
/// sliders need to know about one.
struct Parameter {
  std::string name;          ///< on the command line after --, and the key in JSON
  std::string metavar;       ///< H, X,Y,Z, or the names of an enumeration: cells|uniform
  std::string unit;          ///< empty if it has none
  std::string default_text;  ///< the default as --help prints it
  std::string help;
  SceneMember member;
  Range range = {};
  std::string unset = {};   ///< the word for an optional that is unset: `auto` or `none`
  bool positional = false;  ///< given by its place, not by --name
  bool common = false;      ///< one of the few that --help lists; --help-all lists all
  bool march_only = false;  ///< the medium does not depend on it
  UnderTolerance under_tolerance = UnderTolerance::free;
  OfVolume of_volume = OfVolume::scenes;
  ParameterGroup group = ParameterGroup::input;
};

/// The table, in the order in which --help prints it.
const std::vector<Parameter>& parameters();

/// The parameter of that name, or null.
const Parameter* find_parameter(std::string_view name);

/// Sets one parameter from the command line's syntax: 0.5, 1,2,3, 640x480, 512M, psi-weighted.
/// Throws Error(usage), which names the option, the text and what is expected.
void set_parameter(Scene& scene, std::string_view name, std::string_view text);

/// The value as set_parameter reads it, with enough digits to give the same number.
std::string parameter_text(const Scene& scene, const Parameter& parameter);
std::string parameter_text(const Scene& scene, std::string_view name);

/// Whether its value is a colour: R,G,B are linear, 1 is white; #rgb, #rrggbb and the names of CSS
/// are sRGB, which is decoded.
bool is_color(const Parameter& parameter);

/// What to say about a colour's text of whole numbers up to 255: three of them behind the medium
/// are read as sRGB codes, while light may be brighter than white. Empty if there is nothing to
/// say.
std::string color_notice(const Parameter& parameter, std::string_view text);

/// Whether the medium may depend on the parameter: its grids, atlases or light. If not, one Session
/// draws scenes that differ in it.
bool belongs_to_medium(const Parameter& parameter);

/// Whether it names a grid that the march reads beside the density: luminance-grid, emission-grid.
bool names_side_grid(const Parameter& parameter);

bool has_same(const Scene& a, const Scene& b, const Parameter& parameter);
/// Sets the parameter of a scene to that of another.
void copy_parameter(const Scene& from, Scene& to, const Parameter& parameter);
bool has_default(const Scene& scene, const Parameter& parameter);
/// The parameter is then not given (see is_given).
void set_default(Scene& scene, const Parameter& parameter);
/// Whether a text has set the parameter, or it differs from its default.
bool is_given(const Scene& scene, const Parameter& parameter);
bool is_given(const Scene& scene, std::string_view name);

/// A parameter that the command line sets.
struct Setting {
  std::string name;
  std::string text;
};

/// What the command line must set to make `to` of `from`, except for the look's name.
std::vector<Setting> changed_settings(const Scene& from, const Scene& to);

/// Applies the command line to a scene from a file. A given parameter also clears the file's
/// parameters that it contradicts (--sampling cells clears a step, --tolerance the whole method).
void apply_over(Scene& scene, std::span<const Setting> settings);

/// Throws Error(usage) if parameters contradict each other.
void validate(const Scene& scene);

/// Whether a further volume may have a value of its own.
bool may_be_of_volume(const Parameter& parameter);
/// The scene of one of the further volumes in `scene.volumes`, "FILE NAME=VALUE ...": its file and
/// what it has for itself, the rest as in `scene`. Throws Error(usage).
Scene scene_of_volume(const Scene& scene, std::string_view text);
/// Throws Error(usage) if there are further volumes, which `who` does not show.
void check_one_volume(const Scene& scene, std::string_view who);
/// Throws Error(usage) if further volumes cannot be drawn as the scene asks. Part of validate().
void validate_volumes(const Scene& scene);

/// The tolerance of a picture if its scene leaves the method open.
inline constexpr double default_tolerance = 1e-3;

/// Whether the scene is marched (the reference does not march) and sets neither a tolerance nor a
/// parameter of the method.
bool leaves_method_open(const Scene& scene);

/// The scene with default_tolerance if it leaves the method open.
Scene with_default_tolerance(Scene scene);

/// Throws Error(usage) if a parameter of the method is set although `chooser`, an option, chooses
/// the method.
void check_method_unset(const Scene& scene, std::string_view chooser);

/// All parameters by name, in the table's order. Numbers are numbers, vectors are arrays, unset
/// optionals are their word. scene_from_json reads every number back as the same bits.
std::string to_json(const Scene& scene);

/// Parameters missing from the text have their defaults. Values may be strings in the command
/// line's syntax. Throws Error(usage): not JSON, an unknown name, a bad value; `source` names the
/// file in that message.
Scene scene_from_json(std::string_view text, std::string_view source = "scene");

}  // namespace psivox
