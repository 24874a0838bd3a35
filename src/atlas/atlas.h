#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <vector>

#include "field/index_space.h"
#include "psivox/field.h"
#include "psivox/scene.h"

namespace psivox {

/// A brick owns 8^3 cells, so it stores 9^3 values: its 8^3 voxels and an apron on the + side.
inline constexpr int brick_cells = 8;
inline constexpr int brick_values = 9;
inline constexpr int brick_texels = brick_values * brick_values * brick_values;

/// Entries of the page table: the kind in the two top bits, a payload in the rest.
/// shaders/atlas.glsl, which reads them, documents the payload of each kind.
enum class EntryKind : std::uint32_t { empty = 0, constant = 1, brick = 2, child = 3 };

inline constexpr std::uint32_t entry_payload_bits = 30;
constexpr std::uint32_t make_entry(EntryKind kind, std::uint32_t payload) {
  return std::uint32_t(kind) << entry_payload_bits | payload;
}
constexpr EntryKind entry_kind(std::uint32_t entry) {
  return static_cast<EntryKind>(entry >> entry_payload_bits);
}
constexpr std::uint32_t entry_payload(std::uint32_t entry) {
  return entry & ((1u << entry_payload_bits) - 1);
}

/// Bits of a brick's slot in a table with octants. Above them is a bit for each octant of 4^3 cells
/// that holds no visible one, z fastest.
inline constexpr std::uint32_t entry_slot_bits = 22;

/// Statistics of a brick's first channel, used to choose how to march it.
struct BrickStats {
  float min = 0;
  float max = 0;
  float second_difference = 0;  ///< largest |v[i-1] - 2 v[i] + v[i+1]| along the three axes
  bool absent = false;          ///< some values are: these do not count
};

/// The sparse structure over bricks: a dense top table and, for boxes too large for one, tables of
/// 8^3 entries below it. A top entry spans 8^levels voxels, an entry of the lowest level one brick.
struct PageTable {
  glm::ivec3 min{0};       ///< smallest voxel of entry (0,0,0), a multiple of 8
  glm::ivec3 top_size{0};  ///< entries of the dense top table, z fastest
  int levels = 1;
  bool octants = false;                ///< entries of bricks tell which octants hide
  std::vector<std::uint32_t> entries;  ///< top table, then the tables of 512

  /// Slot of a brick's entry.
  std::uint32_t slot(std::uint32_t entry) const {
    return entry_payload(entry) & ((1u << (octants ? entry_slot_bits : entry_payload_bits)) - 1);
  }
};

/// Calls visit(entry, first, width) for the entries of a page table but children and what is empty:
/// the first brick that it stands for, relative to the table's, and how many along each axis.
template <typename Visit>
void for_entries(const PageTable& pages, const Visit& visit) {
  const auto walk = [&](const auto& self, std::size_t index, const glm::ivec3& size, int level,
                        const glm::ivec3& first) -> void {
    const int width = 1 << (3 * level);
    for_points({glm::ivec3(0), size - 1}, [&](const glm::ivec3& in_table) {
      const std::uint32_t entry = pages.entries[index++];
      const glm::ivec3 at = first + in_table * width;
      if (entry_kind(entry) == EntryKind::child)
        self(self, entry_payload(entry), glm::ivec3(8), level - 1, at);
      else if (entry_kind(entry) != EntryKind::empty)
        visit(entry, at, width);
    });
  };
  walk(walk, 0, pages.top_size, pages.levels - 1, glm::ivec3(0));
}

/// Least and greatest of some values; max < min: all are absent.
struct ValueRange {
  float min = 0;
  float max = 0;
};

/// Whether a cell with these ranges of the field's and a companion's values is visible. Whatever
/// lies within ranges that are not visible is not visible either.
using Visibility = std::function<bool(const ValueRange& own, const ValueRange& companions)>;

inline bool is_not_zero(const ValueRange& own, const ValueRange& /*companions*/) {
  return own.min != 0 || own.max != 0;
}

/// The same where all values of a cell may be absent.
inline bool sees(const Visibility& visible, const ValueRange& own,
                 const ValueRange& companions = {}) {
  return own.min <= own.max && visible(own, companions);
}

struct AtlasOptions {
  /// By the values of the field and of `companion`. The atlas stores visible cells only. If unset,
  /// is_not_zero.
  Visibility visible{};
  bool sees(const ValueRange& own, const ValueRange& companions = {}) const {
    return visible ? psivox::sees(visible, own, companions)
                   : own.min <= own.max && is_not_zero(own, companions);
  }
  /// A scalar field of the same transform and domain that also decides visibility. It must be 0
  /// wherever the field has no leaf and no tile 8 voxels wide. Null means 0 everywhere.
  std::shared_ptr<const Field> companion{};
  /// Also stores what a look-up one voxel along an axis from a visible cell finds, bricks of 0 too.
  bool with_margin = false;
  /// Boxes of voxels that the march must walk cell by cell because another grid is not empty there.
  /// Where this grid is empty they become constants of 0. The domain grows to hold them.
  std::vector<Box> walked{};
  /// Bricks to store; outside these and their margin, cells are empty. Both ends are inclusive.
  Box region = everywhere;
  /// Gives each visible brick texels of its own, so that another grid can be stored beside it
  /// (build_beside). Left out where that takes far more bricks, or where 0 is visible.
  bool own_texels = false;
  /// Marks octants of bricks that hold no visible cell, where the field alone decides that.
  bool mark_octants = false;
  /// Keeps bricks whose values are all absent, as constants of NaN, apart from those of 0.
  bool keeps_absent = false;
  /// Largest dense top table before another level is put below it.
  std::uint64_t top_entries = std::uint64_t{1} << 22;
};

/// Codes store a brick as offset + step * code, in rows of nine along z. A word of 64 bits has the
/// codes at the ends of 8, 4 or 2 cells. Its last code is repeated as the first of the next word,
/// so that one load has both ends of any cell. The word before the rows has the offset and the
/// step, as floats; the lowest two bits of the step tell the width. Each channel beside the density
/// has words of its own, of the same width: word i of all channels, then word i + 1.
enum class CodeWidth : std::uint8_t { bits7, bits12, bits16 };

/// Words of a channel of a brick of the narrowest codes, which payloads of entries count. Wider
/// ones have two or four times as many.
inline constexpr int code_words = 1 + brick_values * brick_values;

/// The bits of a step that count as 0 to the step itself; the lowest two have the width.
inline constexpr std::uint32_t code_width_bits = (1u << 14) - 1;

constexpr CodeWidth width_of_head(std::uint64_t head) { return CodeWidth(head >> 32 & 3); }

/// The widths of an atlas's bricks, in slot order. Null: no codes.
using CodeWidths = std::shared_ptr<const std::vector<CodeWidth>>;

/// A field as bricks: textured where values differ, one constant where they are all equal, nothing
/// where they are all 0. Values are the grid's own; texels are z fastest, `channels` interleaved.
struct BrickAtlas {
  int channels = 1;
  Box domain;  ///< voxels; cells run from min to max - 1
  PageTable pages;
  std::vector<float> constants;     ///< `channels` floats each
  std::vector<BrickStats> bricks;   ///< one per textured brick, in slot order
  std::vector<glm::ivec3> places;   ///< of these bricks [8 voxels]; of equal ones the first
  bool own_texels = false;          ///< no two share a slot, and constants are 0
  bool absent = false;              ///< some values are NaN: a cell with such a corner is vacuum
  std::shared_ptr<float[]> texels;  ///< brick_texels * channels a slot, or null
  std::shared_ptr<std::uint64_t[]> codes;    ///< instead of texels, see CodeWidth
  std::vector<std::uint32_t> code_places{};  ///< of these, by slot: the payloads of their entries
  AtlasSize size;

  std::size_t code_count() const { return codes ? size.texel_bytes / sizeof(std::uint64_t) : 0; }
  std::size_t texel_count() const { return bricks.size() * brick_texels * std::size_t(channels); }
};

/// The largest |v[i-1] - 2 v[i] + v[i+1]| of each textured brick's channels, in slot order. It is
/// taken along the three axes about every voxel, including those on the faces, whose neighbours lie
/// in the next brick. The atlas must have texels. Bricks that are not wanted have 0; if none are
/// listed, all are.
std::vector<float> brick_kinks(const BrickAtlas& atlas, const std::vector<bool>& wanted = {});

/// Sizes of the atlas that build_atlas would make, and the places of its textured bricks if wanted
/// [8 voxels].
AtlasSize predict_atlas(const Field& field, const AtlasOptions& options = {},
                        std::vector<glm::ivec3>* textured = nullptr);

/// Coordinates of the bricks that a leaf reaches into, each once. They follow from the topology
/// alone.
std::vector<glm::ivec3> leaf_bricks(const Field& field);

/// Origins of the domain's blocks of 8^3 voxels that hold a corner of a visible cell, of a region's
/// if there is one, sorted by coordinates. A quantity computed at voxels must be known there
/// to be interpolated wherever the medium is visible. The field must be scalar. Throws
/// Error(memory) beyond 2^24 blocks.
std::vector<glm::ivec3> visible_blocks(const Field& field, const AtlasOptions& options);

/// Finds these blocks from the field's atlas, which was built by these options with own_texels and
/// has texels: nothing is gathered again. Unset if it was not, or if the options have a companion.
std::optional<std::vector<glm::ivec3>> visible_blocks(const Field& field,
                                                      const AtlasOptions& options,
                                                      const BrickAtlas& atlas);

/// Upper bound on the number of visible blocks, unless cells of 0 are visible. It builds no list.
double most_visible_blocks(const Field& field);

/// Builds the atlas by walking leaves, in parallel; the result does not depend on the threads.
/// Bricks also cover absent lower neighbours, because the interpolation of a leaf's values reaches
/// into them. `storage`: the field's, whose blocks go as their bricks are stored.
BrickAtlas build_atlas(const Field& field, const AtlasOptions& options = {},
                       Storage* storage = nullptr);

/// Stores a field of the same transform in the bricks of `layout`, which must have own_texels:
/// pages and slots are the same.
BrickAtlas build_beside(const Field& field, const BrickAtlas& layout, Storage* storage = nullptr);

/// Widths of codes with which no value is off by more than half of a step: of the atlas by slot,
/// and of what is beside it, if anything is. Null if a brick needs more than 16 bits.
CodeWidths code_widths(const BrickAtlas& atlas, std::span<const float> steps,
                       const BrickAtlas* beside = nullptr, float step_beside = 0);

/// A scalar atlas with codes of these widths in place of its texels and of those of `beside`.
/// `replaces`: in the texels' memory if they fit.
BrickAtlas coded(const BrickAtlas& atlas, const std::vector<CodeWidth>& widths,
                 const BrickAtlas* beside = nullptr, bool replaces = false);

}  // namespace psivox
