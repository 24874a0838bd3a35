#pragma once

#include <cstddef>
#include <glm/vec3.hpp>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "psivox/medium.h"
#include "psivox/scene.h"
#include "psivox/vdb.h"

namespace psivox {

/// Whether the values look like those of a scan or a simulation: whole steps of their greatest one,
/// at most 255 of them. In a grid that is not known to be a fog, integers and values that do not
/// fade to 0 tell so too; in one that is full up to its faces, more than a few values.
bool is_scan(const Field& density, bool known_fog, bool full);

/// Whether most values are low, like those of vessels or plumes in their surroundings: their mean
/// is in the lowest quarter of the range.
bool is_mostly_low(const Field& density);

/// Whether values of both signs matter: the lower ones reach a twentieth of the greatest magnitude.
bool is_signed(const Field& density);

/// Whether the values are signed distances in any unit of the world or in voxels, whatever the
/// grid's class says: most of their gradients are equally long (the eikonal equation), and these do
/// not point in one direction as those of a ramp do. Distances that are cut off at a greatest one
/// are distances, too.
bool is_distance(const Field& density);

/// Whether the values are labels: few different ones, which fill bodies of voxels and do not pass
/// from one to the next. They are of a type of whole numbers, two or more whole numbers in floats,
/// or at least 16 whole steps of the greatest. What surrounds the object alike tells nothing.
bool is_labels(const Field& density);

/// The value that fills the volume around the object: that of most voxels of the active box's
/// faces. Else their median, if nine of ten are higher than half of the volume, or if they are
/// nearly alike and half of the volume is as they are. Unset: there is none.
std::optional<double> outside_value(const Field& density);

/// Whether the outside is 0 to a fiftieth of the greatest magnitude. Where there is none: whether
/// the values lie about 0, by their median and the ends of 98 % of them.
bool is_about_0(const Field& density);

/// Whether the rays of a field that has an outside soon reach values that stay: it is a body, not a
/// gas.
bool is_body(const Field& density);

struct SampledVoxel {
  glm::ivec3 voxel;
  float value;  ///< first channel; not 0
};

/// About `wanted` of the voxels in the box of active ones whose values are not 0, spread evenly, in
/// a fixed order. The same values give the same sample, whether tiles or leaves hold them and
/// wherever leaves begin.
std::vector<SampledVoxel> sample_voxels(const Field& field, std::size_t wanted);

/// Files of assets/looks by name: `smoke.json`.
const std::map<std::string, std::string>& embedded_looks();

/// A scalar grid that glows.
struct Flame {
  std::string grid;     ///< empty: none
  double greatest = 0;  ///< value
  bool kelvin = false;  ///< its values are temperatures, at which bodies glow
};

/// The file's grid of a flame, by its name; empty if it has none.
std::string flame_grid(const VdbFile& file);

/// What glows beside a file's density: its flame, if it has a grid of that name; else its heat.
/// Nothing glows where no value is above 0.
Flame find_flame(const VdbFile& file, const std::string& density);

/// Sets the emission that `asked` leaves open to black bodies over a flame. Values above 200 are
/// Kelvin; others become 800 K at 0 and 2300 K at the greatest. The emission's scale makes the
/// brightest hundredth of what glows four times as bright as white, which a filmic curve shows as
/// nearly white with red edges. A flame that the camera does not see
/// sets nothing.
void set_flame(const Scene& asked, const VdbFile& file, const Flame& flame, Scene& scene);

/// Fields of a file, read again only for a scene that needs others.
class KeptFields {
 public:
  KeptFields(const VdbFile& file, const Parts& parts) : file_(file), parts_(parts) {}

  const VdbFile& file() const { return file_; }
  /// The fields by which a view is chosen, all of them to be drawn too.
  const MediumFields& of(const Scene& scene);
  /// Keeps what a view of them tells those that follow.
  void keep(const View& view) { fields_->subject = KnownSubject::of(view); }
  /// The same, with the density to draw.
  MediumFields drawn(const Scene& scene);
  /// What glows beside the scene's density.
  const Flame& flame(const Scene& scene);
  /// Whether the scene's density holds labels.
  bool are_labels(const Scene& scene);

 private:
  const VdbFile& file_;
  const Parts& parts_;
  std::optional<MediumFields> fields_;
  std::shared_ptr<const Field> drawn_;  ///< see MediumFields
  std::string key_;
  std::optional<Flame> flame_;
  std::optional<bool> labels_;  ///< of the fields
};

/// A scene while a look chooses what comes from the file's values.
struct Choosing {
  const Scene& asked;  ///< without the look
  KeptFields& fields;
  Scene& scene;
  /// The scene's view; unset if it is not known. Making it takes longer than most choices.
  std::optional<View> view = {};
};

/// The grid that attenuates: the scene's, or the file's best.
std::string density_grid(const Scene& scene, const VdbFile& file);

/// Names in a look's list `choose`; see with_look.
std::vector<std::string> choice_names();

/// Makes one of these choices. Throws what make_view throws.
void choose(const std::string& name, Choosing& all);

}  // namespace psivox
