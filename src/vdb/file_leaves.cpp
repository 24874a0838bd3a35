#include "file_leaves.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/common.hpp>
#include <numeric>
#include <utility>

#include "leaf_lengths.h"
#include "psivox/error.h"
#include "sanitise.h"

namespace psivox::vdb {
namespace {

constexpr std::size_t batch_leaves = 2048;  // 4 MiB of values

/// The lengths of a leaf's values, where it has neither an inactive value nor a mask of them, which
/// are behind their kind. [bytes]
constexpr std::int64_t head_bytes = 32;

bool in_box(const Box& box, const glm::ivec3& voxel) {
  return glm::clamp(voxel, box.min, box.max) == voxel;
}

/// Adds what is in a leaf's values, which become sanitised.
void add_leaf(const glm::ivec3& origin, float* values, const LeafMask& active, int channels,
              float smallest, const Box& box, ValueSurvey& survey) {
  survey.bad = survey.bad + sanitise_leaf(values, channels, smallest);
  const auto stride = static_cast<std::size_t>(channels);
  for (std::size_t i = 0; i < kLeafVoxels * stride; ++i)
    if (std::isfinite(values[i])) survey.largest = std::max(survey.largest, values[i]);
  const bool inside = in_box(box, origin) && in_box(box, origin + 7);
  for (std::size_t i = 0; i < kLeafVoxels; ++i) {
    const float value = values[i * stride];
    const int n = static_cast<int>(i);
    survey.all.add(value);
    if (active.isOn(static_cast<openvdb::Index>(n))) survey.active.add(value);
    if (inside || in_box(box, origin + glm::ivec3(n >> 6, n >> 3 & 7, n & 7)))
      survey.in_box.add(value);
  }
}

}  // namespace

ValueSurvey survey_values(std::span<const LeafMask> active, float* values, int channels,
                          float smallest, const Box& box,
                          const std::function<glm::ivec3(std::size_t)>& origin_of) {
  const std::size_t length = kLeafVoxels * static_cast<std::size_t>(channels);
  return tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, active.size(), 64), ValueSurvey(),
      [&](const auto& some, ValueSurvey survey) {
        for (std::size_t n = some.begin(); n != some.end(); ++n)
          add_leaf(origin_of(n), values + n * length, active[n], channels, smallest, box, survey);
        return survey;
      },
      std::plus<>());
}

std::size_t FileLeaves::floats_per_leaf() const {
  return kLeafVoxels * static_cast<std::size_t>(decoder_.channels());
}

void FileLeaves::find(std::size_t leaves, std::istream& stream, FileBuffer& buffer,
                      const Visit& visit) {
  places_.reserve(leaves + 1);
  places_.push_back(stream.tellg());
  for_batches(leaves, visit, /*in_runs=*/true, [&](std::size_t end) {
    while (places_.size() <= end) {
      decoder_.skip(stream);
      places_.push_back(stream.tellg());
    }
    buffer.read_to(stream.tellg());
  });
}

void FileLeaves::find(const Topology& topology, std::string_view delayed_load, std::istream& stream,
                      FileBuffer& buffer, std::int64_t end) {
  const std::int64_t begin = stream.tellg();
  places_ = leaf_lengths(delayed_load, topology, decoder_.coding(), decoder_.value_bytes());
  places_.insert(places_.begin(), begin);
  std::partial_sum(places_.begin(), places_.end(), places_.begin());
  if (places_.size() <= topology.leaves.size() || places_.back() != end) {
    places_.assign(1, begin);
    // small leaves are read in fewer calls than skipped
    const auto leaves = static_cast<std::int64_t>(topology.leaves.size());
    if (end - begin > 4 * head_bytes * leaves) buffer.read_only(head_bytes);
    for (const std::uint16_t active : topology.active) {
      decoder_.skip(stream, active);
      places_.push_back(stream.tellg());
    }
    buffer.read_only(0);
  }
  origins_ = topology.leaves;
  active_box_ = topology.summary.active_box;
}

void FileLeaves::visit(const Visit& visit) const {
  for_batches(places_.size() - 1, visit, /*in_runs=*/false, [](std::size_t) {});
}

void FileLeaves::for_batches(std::size_t leaves, const Visit& visit, bool in_runs,
                             const std::function<void(std::size_t end)>& prepare) const {
  LeafBatch batch;
  std::vector<LeafPlace> places;
  for (; batch.first < leaves; batch.first += batch.count) {
    batch.count = std::min(batch_leaves, leaves - batch.first);
    batch.values.resize(batch.count * floats_per_leaf());
    batch.active.resize(batch.count);
    prepare(batch.first + batch.count);
    places.clear();
    for (std::size_t n = batch.first; n < batch.first + batch.count; ++n)
      places.push_back({places_[n], places_[n + 1]});
    decoder_.decode(places, in_runs, batch.values.data(), batch.active.data());
    visit(batch);
  }
}

void FileLeaves::decode(std::span<const std::uint32_t> leaves, float* values,
                        LeafMask* active) const {
  std::vector<LeafPlace> places;
  places.reserve(leaves.size());
  for (const std::uint32_t leaf : leaves) {
    if (leaf + std::size_t{1} >= places_.size())
      throw Error(ExitCode::input, subject_ + "has no leaf of that number");
    places.push_back({places_[leaf], places_[leaf + 1]});
  }
  try {
    decoder_.decode(places, /*in_runs=*/false, values, active);
  } catch (const std::exception& e) {
    throw Error(ExitCode::input, subject_ + "cannot be read again: " + e.what());
  }
}

void FileLeaves::read(std::span<const std::uint32_t> leaves, float* values) const {
  decode(leaves, values, nullptr);
  sanitise_all(leaves.size(), values);
}

void FileLeaves::sanitise_all(std::size_t leaves, float* values) const {
  const std::size_t length = floats_per_leaf();
  tbb::parallel_for(std::size_t{0}, leaves, [&](std::size_t n) {
    float* const leaf = values + n * length;
    if (sanitise_leaf(leaf, decoder_.channels(), smallest_).positive_infinite == 0) return;
    for (std::size_t i = 0; i < length; ++i) leaf[i] = std::min(leaf[i], largest_);
  });
}

void FileLeaves::read_active(std::span<const std::uint32_t> leaves, float* values) const {
  std::vector<LeafMask> active(leaves.size());
  decode(leaves, values, active.data());
  sanitise_all(leaves.size(), values);
  const auto stride = static_cast<std::size_t>(decoder_.channels());
  for (std::size_t n = 0; n < leaves.size(); ++n)
    for (auto off = active[n].beginOff(); off; ++off)
      values[n * floats_per_leaf() + off.pos() * stride] = std::numeric_limits<float>::quiet_NaN();
}

ValueSurvey FileLeaves::survey(std::span<const std::uint32_t> leaves, float* values) const {
  if (origins_.empty()) throw Error(ExitCode::input, subject_ + "has been surveyed");
  std::vector<LeafMask> active(leaves.size());
  decode(leaves, values, active.data());
  return survey_values(active, values, decoder_.channels(), smallest_, active_box_,
                       [&](std::size_t n) { return origins_[leaves[n]]; });
}

}  // namespace psivox::vdb
