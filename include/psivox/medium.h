#pragma once

#include <cstdint>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "psivox/camera.h"
#include "psivox/field.h"
#include "psivox/scene.h"
#include "psivox/team.h"
#include "psivox/vdb.h"

namespace psivox {

class Environment;
class TransferFunction;
struct Holdout;

/// The source of the luminance L. It decides what the march fetches and sums.
enum class LuminanceSource : int {
  constant,  ///< L = color: no weights, no sum, only the optical depth
  density,   ///< L = color * scale * value of the density grid itself: no further fetch
  scalar,    ///< L = color * scale * value of a scalar grid
  vector,    ///< L = color * scale * value (vec3) of a grid
  transfer,  ///< L = color * colour of the value by the transfer function
};

/// Parallel light that is scattered once.
struct ParallelLight {
  glm::dvec3 direction{0};  ///< of travel, normalised [world, or the camera's axes]
  glm::dvec3 radiance{0};   ///< colour times albedo
  bool of_camera = false;
  bool operator==(const ParallelLight&) const = default;
};

/// All light that is scattered once.
struct ScatteredLight {
  std::vector<ParallelLight> lights;
  glm::dvec3 sky{0};    ///< radiance from every direction times albedo; 0: none
  bool tinted = false;  ///< times the source's luminance too: a transfer function's colours
  /// Its factor at each point: a grid of it, or three whose values are red, green and blue times
  /// the density. Empty: 1.
  std::vector<std::shared_ptr<const Field>> albedo{};
  bool operator==(const ScatteredLight&) const = default;
};

/// A grid that radiates by itself, whatever attenuates there.
struct Emission {
  std::shared_ptr<const Field> field;
  double scale = 1;      ///< emission = scale * value [radiance/world unit]
  double brightest = 0;  ///< bound of the radiance along any line; set by make_view
};

/// A surface of the density's own values.
struct Surface {
  double isovalue = 0;
  glm::dvec3 color{1};
  double opacity = 1;
  bool operator==(const Surface&) const = default;
};

/// A scene's participating medium, resolved: grids read, `auto` replaced by numbers.
struct Medium {
  std::shared_ptr<const Field> density;
  double extinction = 1;  ///< tau = extinction * value, or attenuation of it [1/world unit]
  LuminanceSource source = LuminanceSource::constant;
  glm::dvec3 color{1};    ///< luminance * luminance_scale where a grid multiplies it
  glm::dvec3 ambient{0};  ///< added to L, whatever its source and the phase
  double brightest = 1;   ///< bound of L in any channel; without the light that is not in it yet
  std::shared_ptr<const Field> luminance;  ///< for scalar and vector sources, else null
  /// tau = extinction * this function's attenuation of the value; null: extinction * value.
  std::shared_ptr<const TransferFunction> transfer;
  bool nearest = false;  ///< values are those of the nearest voxels: labels are not interpolated
  /// The density's gradient magnitudes [value/world unit], with its domain and transform, if
  /// `transfer` has a gradient; else null.
  std::shared_ptr<const Field> gradient;
  std::vector<Emission> emission{};     ///< of all grids that emit; they add up
  std::vector<Surface> surfaces{};      ///< under Mode::isosurface, by ascending values
  double least_value = 0;               ///< maxima no nearer to 0 show something; so much is a fall
  std::optional<ScatteredLight> light;  ///< not in the luminance yet, see light.h
  bool lit = false;          ///< the luminance has that light, wherever the density attenuates
  bool lit_colors = false;   ///< of which the colours of `transfer` are a factor where a ray is
  glm::dvec3 phase_axis{0};  ///< direction of the light if scattering depends on the ray's; else 0
  double phase_g = 0;        ///< mean cosine of scattering about it
  /// Further volumes, each on a lattice of its own: tau = extinction * value, of constant luminance
  /// or lit. Extinctions and emissions add up, luminances weigh by extinction.
  std::vector<Medium> others{};
};

/// The medium, the camera, what it looks at, and the scene with all optionals resolved, so that
/// rendering `scene` again gives the same picture.
struct View {
  Scene scene;
  Medium medium;
  Camera camera;
  std::shared_ptr<const Subject> subject;
  /// What the scene's holdout holds, once it is read for a picture; null: no ray is held out.
  std::shared_ptr<const Holdout> holdout{};
  /// What the scene's environment holds, once it is read for a picture; null: there is none.
  std::shared_ptr<const Environment> environment{};
};

/// Bound of the radiance of any ray through a medium and its further volumes, in any channel.
double brightest_ray(const Medium& medium);

/// Henyey and Greenstein's phase function over the isotropic one (1941, eq. 2), of the mean cosine
/// `g` and the cosine of the angle between the ways of the light before and after.
double henyey_greenstein(double g, double cosine);

/// Factor of a lit medium's luminance along a ray of this normalised direction: its phase function.
/// It is 1 if phase_g is 0.
double phase_factor(const Medium& medium, const glm::dvec3& ray_direction);

/// The scene's lights as they shine on surfaces, turned to the world; their radiance is their
/// colour. None: light comes from the camera.
std::vector<ParallelLight> surface_lights(const View& view);

/// Where the values of a scene's density may be.
struct Parts {
  /// If they take more than half of grid_memory(), they may stay in the file, provided that the
  /// scene can be drawn in parts.
  bool allowed = false;
  /// In a team of several they stay in the file if they can, however few they are. Each member
  /// reads the values of its own part.
  std::shared_ptr<Team> team = alone();
};

/// Which pictures can be drawn in parts, if the scene's cannot, as the rest of a sentence; else
/// empty.
std::string parts_obstacle(const Scene& scene);

/// Bytes that a scene's grids may take on host and GPU together: its memory limit without what the
/// program itself and the picture take, but no less than 32 MiB or the limit; or four fifths of the
/// memory that is free, if it has no limit. 0: not known.
std::uint64_t grid_memory(const Scene& scene);

/// The transform of a grid as the scene places its volume and its values.
glm::dmat4 placement(const Scene& scene, const glm::dmat4& world_from_index);

/// A grid that emits, and the scene's options for it.
struct EmissionField {
  const EmissionOptions* options = nullptr;
  std::shared_ptr<const Field> field;
};

/// The subject of a view, and what it follows from.
struct KnownSubject {
  std::weak_ptr<const Field> density;
  std::shared_ptr<const TransferFunction> transfer;
  Mode mode = {};
  std::vector<Surface> surfaces{};
  std::shared_ptr<const Subject> subject;

  /// What is known of a view whose medium neither glows nor has further volumes; else nothing.
  static std::optional<KnownSubject> of(const View& view);
  /// Whether it is the subject of this medium too.
  bool serves(const Medium& medium, Mode seen_by) const;
};

/// The grids of a scene. One is null if the scene has none or its mode does not use it. Two may be
/// the same field.
struct MediumFields {
  std::shared_ptr<const Field> density, luminance, temperature;
  std::vector<EmissionField> emission{};
  std::string z_up{};  ///< what tells that the file's Z axis is up, see VolumeFile::z_up
  /// The density to draw, if its values stay in the file and `density` is an overview of it, by
  /// which the view is chosen.
  std::shared_ptr<const Field> drawn{};
  /// The subject of a view of the density that was made before.
  std::optional<KnownSubject> subject{};
  std::vector<std::shared_ptr<const Field>> albedo{};  ///< as in ScatteredLight
  std::vector<MediumFields> others{};                  ///< of further volumes
  std::string density_key{};  ///< what the density follows from: see KnownDensity
};

/// The density of fields that were read before, for another scene of the file.
struct KnownDensity {
  std::shared_ptr<const Field> field{};  ///< null: none is known
  std::string key{};                     ///< MediumFields::density_key
  /// Percentages of which looks may ask next, to be found where values below 0 stay.
  std::span<const double> percentiles{};

  /// Whether it is the density of this scene, too.
  bool serves(const Scene& scene) const;
};

/// Reads the grids that the picture depends on under the scene's mode. `empty`: grids without
/// active voxels count, as zeros. `known`: a density that serves the scene, if there is one. Throws
/// Error(input), Error(memory).
MediumFields read_fields(const Scene& scene, const VolumeFile& file, bool empty = false,
                         const Parts& parts = {}, const KnownDensity& known = {});
/// The grids of a file that an albedo grid's name stands for: the one of that name, or the three
/// NAME_r, NAME_g and NAME_b; none if the file has neither.
std::vector<std::string> albedo_grids(const VolumeFile& file, const std::string& name);
/// Reads those of the scene's further volumes into fields.others, if they are not there.
void read_volumes(const Scene& scene, MediumFields& fields);
/// Equal for scenes to which read_fields gives the same fields of a file.
std::string fields_key(const Scene& scene);

/// Resolves the scene's unset optionals and reads its transfer function. Of a density whose values
/// stay in the file the picture must be one that is drawn in parts.
/// Throws Error(input), Error(usage), Error(memory).
View make_view(const Scene& scene, const MediumFields& fields);
View make_view(const Scene& scene, const VolumeFile& file);

/// Makes a view of fields in memory; `luminance` may be null.
View make_view(const Scene& scene, std::shared_ptr<const Field> density,
               std::shared_ptr<const Field> luminance);

/// Transmittance at which rays end: the scene's own. If it has none, a ray leaves out at most half
/// of the tolerance in any channel and a quarter of it in opacity.
double early_termination(const View& view);

/// Extinction for which the mean ray through the grid's middle has optical depth 3. The mean is
/// over 17 x 17 rays along each index axis through the middle half of the domain, or through the
/// whole domain if the middle is empty; rays that meet nothing do not count. An all-zero field
/// gives 1. With a transfer function, which must have no gradient, it uses the voxels'
/// attenuations.
double auto_extinction(const Field& field, const TransferFunction* transfer = nullptr);

}  // namespace psivox
