#include "background.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "grid_types.h"
#include "psivox/error.h"
#include "tree_nodes.h"

namespace psivox::vdb {
namespace {

std::string short_text(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

/// Tiles of the root that may be added: 28 MB of them.
constexpr double kMaxRootTiles = 1 << 20;

/// The value in a component's type. Throws std::runtime_error if that type does not have it.
template <typename T>
T component_of(double value) {
  using Limits = std::numeric_limits<T>;
  // 2^63 is no int64, but the nearest double of the greatest.
  const bool within = value >= double(Limits::lowest()) && value < double(Limits::max()) + 1;
  if (!within || (Limits::is_integer && value != std::trunc(value)))
    throw std::runtime_error("has no value " + short_text(value) +
                             ", which --background-value asks for");
  return static_cast<T>(value);
}

template <typename GridT>
void replace(GridT& grid, const typename GridT::ValueType& value) {
  using TreeT = typename GridT::TreeType;
  const typename GridT::ValueType old = grid.background();
  const TreeNodes<TreeT> nodes(grid.tree());
  nodes.for_each_with_tiles([&](auto& node, int) { replace_off(node, old, value); });
  for (auto* leaf : nodes.leaves) replace_off(*leaf, old, value);
  nodes.root.setBackground(openvdb::zeroVal<typename GridT::ValueType>(),
                           /*updateChildNodes=*/false);
}

/// Adds tiles to the root where it has neither a tile nor a node.
template <typename GridT>
void fill_root(GridT& grid, const Box& box, const typename GridT::ValueType& value) {
  auto& root = grid.tree().root();
  constexpr int width = int(std::decay_t<decltype(root)>::ChildNodeType::DIM);
  // One voxel around the active ones belongs to the domain.
  const auto first = [&](int axis) { return (box.min[axis] - 1) & ~(width - 1); };
  double count = 1;
  for (int axis = 0; axis < 3; ++axis)
    count *= (double(box.max[axis]) + 1 - first(axis)) / width + 1;
  if (count > kMaxRootTiles)
    throw std::runtime_error(
        "is too wide to be filled with --background-value; only 0 needs no memory");
  for (int x = first(0); x <= box.max.x + 1; x += width)
    for (int y = first(1); y <= box.max.y + 1; y += width)
      for (int z = first(2); z <= box.max.z + 1; z += width) {
        const openvdb::Coord origin(x, y, z);
        if (root.getValueDepth(origin) < 0) root.addTile(origin, value, /*state=*/false);
      }
}

/// Least and greatest of 0 and the finite active values.
template <typename GridT>
std::pair<double, double> active_bounds(const GridT& grid) {
  std::pair<double, double> bounds{0, 0};
  for (auto it = grid.cbeginValueOn(); it; ++it) {
    const double value = static_cast<double>(*it);
    if (!std::isfinite(value)) continue;
    bounds = {std::min(bounds.first, value), std::max(bounds.second, value)};
  }
  return bounds;
}

}  // namespace

void complete_level_set(openvdb::GridBase& grid) {
  if (!is_fog_of_wrong_class(grid)) return;
  grid.apply<openvdb::TypeList<openvdb::FloatGrid, openvdb::DoubleGrid>>([](auto& typed) {
    using ValueT = typename std::decay_t<decltype(typed)>::ValueType;
    const auto [least, greatest] = active_bounds(typed);
    if (!(least < 0 && greatest > 0)) return;
    const auto outside = static_cast<ValueT>(greatest);
    replace(typed, outside);
    typed.tree().root().setBackground(outside, /*updateChildNodes=*/false);
  });
}

std::optional<double> other_background(const openvdb::GridBase& grid, const GridSummary& summary,
                                       const ReadOptions& options, const std::string& subject) {
  if (!has_background(grid, summary)) return {};
  if (options.strict && !options.background)
    throw Error(ExitCode::input,
                subject + "has background " + background_text(summary) +
                    ", which strict reading does not replace; --background-value 0 leaves the"
                    " outside empty");
  return options.background.value_or(0);
}

std::string background_notice(const GridSummary& summary, const ReadOptions& options) {
  return "its background " + background_text(summary) + " is taken as " +
         short_text(options.background.value_or(0)) +
         (options.background ? "" : "; --background-value gives another value");
}

void take_background(openvdb::GridBase& grid, const GridSummary& summary, double value) {
  grid.apply<SupportedGrids>([&](auto& typed) {
    using ValueT = typename std::decay_t<decltype(typed)>::ValueType;
    using Component = typename openvdb::VecTraits<ValueT>::ElementType;
    const ValueT fill(component_of<Component>(value));
    replace(typed, fill);
    if (summary.active_voxels > 0 && fill != openvdb::zeroVal<ValueT>())
      fill_root(typed, summary.active_box, fill);
  });
}

}  // namespace psivox::vdb
