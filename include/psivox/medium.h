#pragma once

#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <vector>

#include "psivox/camera.h"
#include "psivox/field.h"
#include "psivox/scene.h"
#include "psivox/transfer_function.h"
#include "psivox/vdb.h"

namespace psivox {

/// Where L comes from; decides what the march fetches and sums.
enum class LuminanceSource : int {
  constant,  ///< L = color: no weights, no sum, only the optical depth
  density,   ///< L = color * scale * value of the density grid itself: no further fetch
  scalar,    ///< L = color * scale * value of a scalar grid
  vector,    ///< L = color * scale * value (vec3) of a grid
  transfer,  ///< L = color * colour of the value by the transfer function
};

/// Light that is scattered once.
struct ScatteredLight {
  glm::dvec3 direction{0};  ///< along which it travels, normalised [world]
  glm::dvec3 radiance{0};   ///< colour times albedo
  bool tinted = false;  ///< times what the luminance source gives: a transfer function's colours
  bool operator==(const ScatteredLight&) const = default;
};

/// A scene's participating medium, resolved: grids read, `auto` replaced by numbers.
struct Medium {
  std::shared_ptr<const Field> density;
  double extinction = 1;  ///< tau = extinction * value, or attenuation of it [1/world unit]
  LuminanceSource source = LuminanceSource::constant;
  glm::dvec3 color{1};  ///< luminance * luminance_scale where a grid multiplies it
  std::shared_ptr<const Field> luminance;  ///< for scalar and vector sources, else null
  /// tau = extinction * attenuation of the value by this function; null: of the value itself.
  std::shared_ptr<const TransferFunction> transfer;
  /// Where `transfer` has a gradient: the magnitudes of the density's [value/world unit], of its
  /// domain and transform. Else null.
  std::shared_ptr<const Field> gradient;
  std::shared_ptr<const Field> emission;  ///< null: nothing radiates where tau is 0
  double emission_scale = 1;              ///< emission = scale * value [radiance/world unit]
  double isovalue = 0;                    ///< under Mode::isosurface, of the density's own values
  std::optional<ScatteredLight> light;    ///< not in the luminance yet, see light.h
  glm::dvec3 phase_axis{
      0};              ///< direction of the light where scattering depends on the ray's; else 0
  double phase_g = 0;  ///< mean cosine of scattering about it
};

/// What a renderer needs: the medium, the camera and the scene whose optionals are all resolved, so
/// that rendering `scene` again gives the same picture.
struct View {
  Scene scene;
  Medium medium;
  Camera camera;
  glm::dvec3 box_min{0}, box_max{0};  ///< of the density's domain [world units]
};

/// Factor of a lit medium's luminance for a ray of this direction, normalised: Henyey and
/// Greenstein's phase function over the isotropic one. 1 where phase_axis is 0.
double phase_factor(const Medium& medium, const glm::dvec3& ray_direction);

/// The grids of a scene; null: it has none, or its mode does not look at it. One field may be two.
struct MediumFields {
  std::shared_ptr<const Field> density, luminance, temperature, emission;
};

/// Reads those grids that the picture depends on under the scene's mode. Throws Error(input).
MediumFields read_fields(const Scene& scene, const VdbFile& file);

/// Resolves what the scene leaves open; reads its transfer function.
/// Throws Error(input), Error(usage), Error(memory).
View make_view(const Scene& scene, const MediumFields& fields);
View make_view(const Scene& scene, const VdbFile& file);

/// From a density and a luminance at hand, which may be null.
View make_view(const Scene& scene, std::shared_ptr<const Field> density,
               std::shared_ptr<const Field> luminance);

/// Extinction for which the mean ray through the grid's middle has optical depth 3: the mean over
/// 17 x 17 rays along each index axis through the middle half of the domain, those that meet
/// nothing left out; over the whole domain where the middle is empty. 1 for an all-zero field.
/// With a transfer function, which has no gradient, the same of the voxels' attenuations.
double auto_extinction(const Field& field, const TransferFunction* transfer = nullptr);

}  // namespace psivox
