#pragma once

#include <functional>
#include <glm/vec3.hpp>
#include <memory>

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

/// A scene's participating medium, resolved: grids read, `auto` replaced by numbers.
struct Medium {
  std::shared_ptr<const Field> density;
  double extinction = 1;  ///< tau = extinction * value, or attenuation of it [1/world unit]
  LuminanceSource source = LuminanceSource::constant;
  glm::dvec3 color{1};  ///< luminance * luminance_scale where a grid multiplies it
  std::shared_ptr<const Field> luminance;  ///< for scalar and vector sources, else null
  /// tau = extinction * attenuation of the value by this function; null: of the value itself.
  std::shared_ptr<const TransferFunction> transfer;
  std::shared_ptr<const Field> emission;  ///< null: nothing radiates where tau is 0
  double emission_scale = 1;              ///< emission = scale * value [radiance/world unit]
  double isovalue = 0;                    ///< under Mode::isosurface
};

/// What a renderer needs: the medium, the camera and the scene whose optionals are all resolved, so
/// that rendering `scene` again gives the same picture.
struct View {
  Scene scene;
  Medium medium;
  Camera camera;
};

/// Reads the grids that the scene uses and resolves what it leaves open.
/// Throws Error(input), Error(usage).
View make_view(const Scene& scene, const VdbFile& file);

/// The same from fields at hand (tests, other sources than .vdb); luminance may be null.
View make_view(const Scene& scene, std::shared_ptr<const Field> density,
               std::shared_ptr<const Field> luminance);

/// Extinction for which the mean ray through the grid's middle has optical depth 3: the mean over
/// 17 x 17 rays along each index axis through the middle half of the domain, those that meet
/// nothing left out; over the whole domain where the middle is empty. 1 for an all-zero field.
double auto_extinction(const Field& field);

}  // namespace psivox
