#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "march/marcher.h"

namespace psivox {

/// A grid's space in boxes of bricks, by a kd tree whose planes lie between bricks. Together they
/// fill it.
class Regions {
 public:
  /// Splits at the bricks' medians, until no region has more than `most` of them, or one.
  Regions(std::vector<glm::ivec3> bricks, std::size_t most);

  std::size_t count() const { return count_; }
  /// All regions. The boxes' ends are inclusive [bricks].
  std::vector<Box> boxes() const;
  /// The regions in an order in which no ray meets one before an earlier one.
  std::vector<Box> front_to_back(const Camera& camera, const glm::dmat4& world_from_index) const;

 private:
  struct Node {
    Box box;
    int axis = 0;
    int plane = 0;  ///< first brick of the upper child along the axis
    std::unique_ptr<Node> lower, upper;
  };
  std::vector<Box> ordered(const std::function<bool(const Node&)>& lower_first) const;
  void split(Node& node, std::span<glm::ivec3> bricks, std::size_t most);

  Node root_;
  std::size_t count_ = 0;
};

/// The regions by which a view must be drawn because its atlases, on host and GPU, take more than
/// its memory limit, or than four fifths of the memory that is free if it has none; unset if they
/// fit, or if only free memory is short and the picture cannot be drawn in parts. Other grids than
/// the density and its gradient stay whole. Throws Error(memory) if the limit cannot be kept.
/// `limit` stands for the scene's [bytes].
std::optional<Regions> needed_regions(const View& view, const Wish& wish,
                                      std::optional<double> limit = {});

/// Draws with another marcher, region by region, and joins what they show. Each region is
/// converted, uploaded, drawn and dropped.
///
/// A picture's regions come front to back: radiance adds up weighted with the transmittance of the
/// regions before, and transmittances multiply (Max 1995, eq. 8). In cells the picture is that of
/// the whole, apart from rounding. A view with a tolerance is marched exactly. Optical depths
/// towards a light add up over the regions.
class RegionMarcher final : public Marcher {
 public:
  RegionMarcher(Marcher& marcher, const Regions& regions) : marcher_(marcher), regions_(regions) {}

  std::string description() const override { return marcher_.description(); }
  /// It needs no atlas of its session, and chooses no method.
  bool marches() const override { return false; }
  void upload(const MediumAtlas&, Filter) override {}
  LightDepths light_depths(const View& view) override;
  RenderResult render(const View& view, const RenderOptions& options = {}) override;

 private:
  Marcher& marcher_;
  const Regions& regions_;
};

}  // namespace psivox
