#pragma once

#include <cstddef>
#include <glm/vec3.hpp>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "look/field_kind.h"
#include "psivox/medium.h"
#include "psivox/scene.h"
#include "psivox/vdb.h"

namespace psivox {

/// Files of assets/looks by name: `smoke.json`.
const std::map<std::string, std::string>& embedded_looks();

/// A scalar grid that glows.
struct Flame {
  std::string grid;     ///< empty: none
  double greatest = 0;  ///< value
  bool kelvin = false;  ///< its values are temperatures, at which bodies glow
};

/// The file's grid of a flame, by its name; empty if it has none.
std::string flame_grid(const VolumeFile& file);

/// What glows beside a file's density: its flame, if it has a grid of that name; else its heat.
/// Nothing glows where no value is above 0.
Flame find_flame(const VolumeFile& file, const std::string& density);

/// Sets the emission that `asked` leaves open to black bodies over a flame. Values above 200 are
/// Kelvin; others become 800 K at 0 and 2300 K at the greatest. The emission's scale makes the
/// brightest hundredth of what glows four times as bright as white, which a filmic curve shows as
/// nearly white with red edges. A flame that the camera does not see
/// sets nothing.
void set_flame(const Scene& asked, const VolumeFile& file, const Flame& flame, Scene& scene);

/// Fields of a file, read again only for a scene that needs others.
class KeptFields {
 public:
  KeptFields(const VolumeFile& file, const Parts& parts) : file_(file), parts_(parts) {}

  const VolumeFile& file() const { return file_; }
  /// The fields by which a view is chosen, all of them to be drawn too.
  const MediumFields& of(const Scene& scene);
  /// Keeps what a view of them tells those that follow.
  void keep(const View& view) { fields_->subject = KnownSubject::of(view); }
  /// The same, with the density to draw.
  MediumFields drawn(const Scene& scene);
  /// What glows beside the scene's density.
  const Flame& flame(const Scene& scene);
  /// What the values of the scene's density are.
  FieldKind& kind(const Scene& scene) { return kind(of(scene).density); }
  /// The same of a view's density.
  FieldKind& kind(const std::shared_ptr<const Field>& density);

 private:
  const VolumeFile& file_;
  const Parts& parts_;
  std::optional<MediumFields> fields_;
  std::shared_ptr<const Field> drawn_;  ///< see MediumFields
  std::string key_;
  std::optional<Flame> flame_;
  std::optional<FieldKind> kind_;  ///< of the density that was asked about last
};

/// A scene while a look chooses what comes from the file's values.
struct Choosing {
  const Scene& asked;  ///< without the look
  KeptFields& fields;
  Scene& scene;
  /// The scene's view; unset if it is not known. Making it takes longer than most choices.
  std::optional<View> view = {};
  std::optional<double> outside = {};  ///< see LookedScene
};

/// The grid that attenuates: the scene's, or the file's best.
std::string density_grid(const Scene& scene, const VolumeFile& file);

/// Names in a look's list `choose`; see with_look.
std::vector<std::string> choice_names();

/// Makes one of these choices. Throws what make_view throws.
void choose(const std::string& name, Choosing& all);

}  // namespace psivox
