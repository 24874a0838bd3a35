#include "guarded_leaves.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>
#include <vector>

#include "check_field.h"
#include "psivox/error.h"
#include "sanitise.h"

namespace psivox::vdb {

GuardedLeaves::GuardedLeaves(std::unique_ptr<ReaderProcess> process,
                             std::shared_ptr<FileBlocks> file, const FieldFacts& facts,
                             GridRole role)
    : process_(std::move(process)),
      file_(std::move(file)),
      floats_per_leaf_(kLeafVoxels * static_cast<std::size_t>(facts.field.channels)),
      role_(role),
      infinite_(facts.field.survey.has_value()),
      active_tiles_(facts.active_tiles) {}

void GuardedLeaves::ask(std::span<const std::uint32_t> leaves, float* values, ValueSurvey* survey,
                        bool active) const {
  constexpr std::size_t at_once = 4096;  // 8 MiB of scalars
  const std::lock_guard lock(mutex_);
  while (!leaves.empty()) {
    const auto some = leaves.first(std::min(at_once, leaves.size()));
    const std::size_t floats = some.size() * floats_per_leaf_;
    Packer request;
    request(LeavesRequest{{some.begin(), some.end()}, survey != nullptr, active});
    LeavesAnswer found;
    try {
      const std::string answer =
          process_->ask(MessageKind::leaves, request.text(), /*descriptor=*/-1, /*grid=*/"", {});
      Unpacker unpack(answer);
      unpack(found);
      unpack.end();
    } catch (const Error&) {
      throw;
    } catch (const std::exception& error) {
      throw Error(ExitCode::input, nonsense(*file_, error.what()));
    }
    if (found.values.size() != floats * sizeof(float))
      throw Error(ExitCode::input, nonsense(*file_, "another number of values"));
    std::memcpy(values, found.values.data(), found.values.size());
    std::vector<float> known(values, values + (active ? floats : 0));
    for (float& value : known)
      if (std::isnan(value)) value = 0;
    const std::span<const float> to_check = active ? known : std::span<const float>(values, floats);
    if (!all_good(to_check, role_, infinite_) || !is_possible(found.survey))
      throw Error(ExitCode::input, nonsense(*file_, "values are not finite, or negative"));
    if (survey) *survey = *survey + found.survey;
    values += floats;
    leaves = leaves.subspan(some.size());
  }
}

}  // namespace psivox::vdb
