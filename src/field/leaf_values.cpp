#include "field/leaf_values.h"

#include <algorithm>
#include <glm/vector_relational.hpp>
#include <iterator>
#include <memory>
#include <vector>

#include "base/memory.h"
#include "base/text.h"
#include "psivox/error.h"

namespace psivox {
namespace {

constexpr std::size_t read_at_once = 2048;  // 4 MiB of scalars

std::size_t floats_per_leaf(const Field& field) { return 512 * std::size_t(field.channels); }

/// Reads some leaves of a file, a few at a time: another process may read them.
std::vector<Leaf> read_leaves(const Field& field, std::span<const std::uint32_t> numbers,
                              float* values) {
  for (std::size_t n = 0; n < numbers.size(); n += read_at_once)
    field.reader(field, numbers.subspan(n, std::min(read_at_once, numbers.size() - n)),
                 values + n * floats_per_leaf(field));
  std::vector<Leaf> leaves;
  leaves.reserve(numbers.size());
  for (const std::uint32_t n : numbers) {
    leaves.push_back({field.leaves[n].origin, values});
    values += floats_per_leaf(field);
  }
  return leaves;
}

}  // namespace

LeafValues values_of(const Field& field, const Leaf& leaf) {
  if (const int c = field.channels; leaf.values || !field.array)
    return {leaf.values, {64 * c, 8 * c, c, 1}};  // OpenVDB's order
  const auto [x, y, z, channel] = field.array->strides;
  const glm::ivec3& o = leaf.origin;
  return {field.array->first + (o.x * x + o.y * y + o.z * z), field.array->strides};
}

void copy_values(const LeafValues& from, int channels, float* to, const glm::ivec3& size) {
  for (int x = 0; x < size.x; ++x)
    for (int y = 0; y < size.y; ++y)
      from.copy_row(x, y, size.z, channels, to + (x * 8 + y) * 8 * channels);
}

OrderedValues::OrderedValues(const Field& field, const Leaf& leaf)
    : values_(leaf.values), size_(floats_per_leaf(field)) {
  if (values_) return;
  copy_values(values_of(field, leaf), field.channels, copy_.data());
  values_ = copy_.data();
}

std::uint64_t value_bytes(const Field& field) {
  return field.leaves.size() * floats_per_leaf(field) * sizeof(float);
}

void check_in_memory(const Field& field, const std::string& option) {
  if (!field.reader) return;
  throw Error(ExitCode::memory, "grid " + in_quotes(field.name) + " has values of " +
                                    mebibytes(value_bytes(field)) +
                                    ", more than the memory limit leaves room for" +
                                    (option.empty() ? ": only pictures are drawn from it, in parts;"
                                                      " raise --memory-limit"
                                                    : ", and " + option +
                                                          " needs all of them at once; raise"
                                                          " --memory-limit or leave that out"));
}

void visit_leaves(const Field& field, const VisitLeaves& visit, const WantLeaf& wanted) {
  if (!field.reader) return visit(field.leaves);
  std::vector<float> values(read_at_once * floats_per_leaf(field));
  std::vector<std::uint32_t> numbers;
  const auto flush = [&] {
    if (!numbers.empty()) visit(read_leaves(field, numbers, values.data()));
    numbers.clear();
  };
  for (std::size_t n = 0; n < field.leaves.size(); ++n) {
    if (wanted && !wanted(field.leaves[n])) continue;
    numbers.push_back(std::uint32_t(n));
    if (numbers.size() == read_at_once) flush();
  }
  flush();
}

Field part_of_field(const Field& field, const Box& voxels) {
  return part_of_field(field, [&](const Leaf& leaf) {
    return glm::all(glm::lessThanEqual(leaf.origin, voxels.max)) &&
           glm::all(glm::greaterThanEqual(leaf.origin + 7, voxels.min));
  });
}

Field part_of_field(const Field& field, const WantLeaf& wanted) {
  Field part{FieldHead(field), {}, field.tiles};
  if (!field.reader) {
    part.array = field.array;
    part.storage = field.storage;
    part.storage.leaves = 0;
    std::ranges::copy_if(field.leaves, std::back_inserter(part.leaves), wanted);
    return part;
  }
  std::vector<std::uint32_t> numbers;
  for (std::size_t n = 0; n < field.leaves.size(); ++n)
    if (wanted(field.leaves[n])) numbers.push_back(std::uint32_t(n));
  const auto values = page_array<float>(numbers.size() * floats_per_leaf(field));
  part.leaves = read_leaves(field, numbers, values.get());
  part.storage = values;
  return part;
}

}  // namespace psivox
