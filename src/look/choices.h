#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "look/flame.h"
#include "psivox/medium.h"
#include "psivox/scene.h"
#include "psivox/vdb.h"

namespace psivox {

/// Files of assets/looks by name: `smoke.json`.
const std::map<std::string, std::string>& embedded_looks();

/// Fields of a file, read again only for a scene that needs others.
class KeptFields {
 public:
  KeptFields(const VdbFile& file, const Parts& parts) : file_(file), parts_(parts) {}

  const VdbFile& file() const { return file_; }
  /// The fields by which a view is chosen, all of them to be drawn too.
  const MediumFields& of(const Scene& scene);
  /// The same, with the density to draw.
  MediumFields drawn(const Scene& scene);
  /// What glows beside the scene's density.
  const Flame& flame(const Scene& scene);

 private:
  const VdbFile& file_;
  const Parts& parts_;
  std::optional<MediumFields> fields_;
  std::shared_ptr<const Field> drawn_;  ///< see MediumFields
  std::string key_;
  std::optional<Flame> flame_;
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
