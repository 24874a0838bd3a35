#pragma once

#include "march/light.h"
#include "march/medium_atlas.h"
#include "march/pixel_box.h"
#include "psivox/error.h"
#include "psivox/image.h"
#include "psivox/marcher.h"

namespace psivox {

/// The part of the uniform step that is taken in each textured brick of the density's atlas, above
/// 0 and at most 1. Null: 1.
using BrickSteps = std::shared_ptr<const std::vector<float>>;

struct RenderOptions {
  bool count = false;  ///< count segments and look-ups: layers `steps` and `samples`, and the stats
  bool depth = false;  ///< layer `depth`
  bool transmittance = false;  ///< layer `transmittance`
  Progress progress{};
  std::function<void(const DoneTile&)> tile{};  ///< see Wish
  double tile_ms = 1000;                        ///< see Wish
  bool may_update_tables = false;               ///< see Wish
  BrickSteps brick_steps{};
  double ray_cost = 0;  ///< expected look-ups of a ray; 0: not known
  /// Place of a pixel's only sample, in [0, 1)^2; unset: as the view samples pixels.
  std::optional<glm::dvec2> place{};
  /// What the rays of `pixels` have passed before this region, row by row: their optical depths,
  /// on which layer `depth` and the ends of rays depend, or under maxima their greatest values,
  /// behind which the first local maximum may lie. Empty: nothing.
  std::vector<float> passed{};
  /// Part of the picture to draw, alone in the result's image; unset: all of it.
  std::optional<PixelBox> pixels{};
  /// A view of a few rays by the same march. A marcher that rounds draws it too, and gives both to
  /// the GPU before it waits for either.
  std::optional<View> pilot{};
};

struct RenderResult {
  Image image;
  Image pilot;  ///< of RenderOptions::pilot
  RenderStats stats;
};

/// What the march of a view computes, what it leaves out because the picture does not depend on it,
/// and why. Light may still be pending.
std::vector<Explanation> explain(const View& view, const MediumAtlas& atlas);

/// Whether the view's march corrects the ends of its lattice: psi-balanced does, where rays may
/// begin inside the medium and nothing else in the scene forbids it.
bool has_end_corrections(const View& view);

/// Thrown where the device cannot hold what it was given: its memory is full, or its textures are
/// too small. A smaller atlas may fit.
class DeviceFull : public Error {
 public:
  using Error::Error;
};

/// What Session draws with (draw.h). It gives calls in this order: upload, then light_depths or
/// render of a view of that atlas. Only tests call a marcher otherwise.
class Marcher {
 public:
  Marcher() = default;
  virtual ~Marcher() = default;
  Marcher(const Marcher&) = delete;
  Marcher& operator=(const Marcher&) = delete;

  /// GL_RENDERER and GL_VERSION, or what else draws.
  virtual std::string description() const = 0;
  /// Whether it marches the atlas by the view's method, and light within a tolerance will do for
  /// its pictures. The reference reads the grids, in exact light.
  virtual bool marches() const { return true; }
  /// Whether its arithmetic has an error to look for: it is float32.
  virtual bool rounds() const { return false; }
  /// Whether it reads an atlas for exact filtering where it is, not a copy on a device.
  virtual bool draws_in_place() const { return false; }

  /// Takes the atlas, which must stay until the last render, and may copy it when something first
  /// needs the copy. Later renders must ask for the same filter.
  virtual void upload(const MediumAtlas& atlas, Filter filter = Filter::exact) = 0;
  /// Optical depths towards the light of a view whose density is uploaded, with exact filtering:
  /// for lit() (light.h), before the next upload. View and atlas must outlive them. Of several
  /// volumes those are through the first alone, unless the marcher reads the grids.
  virtual LightDepths light_depths(const View& view) = 0;
  /// The columns by which light_depths() would find the depths of a beam in a lattice.
  virtual LatticeColumns light_columns(const LatticeFrame&, const View&, const Beam&) {
    throw Error(ExitCode::failure, description() + " has no lattice of light");
  }
  /// Draws the view's picture from the uploaded atlas, which must be its own.
  virtual RenderResult render(const View& view, const RenderOptions& options = {}) = 0;

  /// Lets another thread draw next.
  virtual void release() {}

  /// Uploads an atlas that its owner keeps, unless it was the last one for the same filter.
  void hold(const std::shared_ptr<const MediumAtlas>& atlas, Filter filter) {
    if (held_.lock() == atlas && held_for_ == filter) return;
    upload_once(*atlas, filter);
    held_ = atlas;
    held_for_ = filter;
  }
  /// Uploads another, which is not asked for again.
  void upload_once(const MediumAtlas& atlas, Filter filter) {
    held_.reset();
    upload(atlas, filter);
  }

 private:
  std::weak_ptr<const MediumAtlas> held_;
  Filter held_for_ = Filter::exact;
};

}  // namespace psivox
