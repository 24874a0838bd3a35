#include "guarded_leaves.h"

#include <algorithm>
#include <cstring>
#include <utility>
#include <vector>

#include "check_field.h"
#include "psivox/error.h"
#include "sanitise.h"

namespace psivox::vdb {

GuardedLeaves::GuardedLeaves(std::unique_ptr<ReaderProcess> process,
                             std::shared_ptr<FileBlocks> file, const Field& field, GridRole role)
    : process_(std::move(process)),
      file_(std::move(file)),
      floats_per_leaf_(kLeafVoxels * static_cast<std::size_t>(field.channels)),
      role_(role),
      infinite_(field.survey.has_value()) {}

void GuardedLeaves::ask(std::span<const std::uint32_t> leaves, float* values,
                        ValueSurvey* survey) const {
  constexpr std::size_t at_once = 4096;  // 8 MiB of scalars
  const std::lock_guard lock(mutex_);
  while (!leaves.empty()) {
    const auto some = leaves.first(std::min(at_once, leaves.size()));
    const std::size_t floats = some.size() * floats_per_leaf_;
    Packer request;
    request(LeavesRequest{{some.begin(), some.end()}, survey != nullptr});
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
    if (!all_good({values, floats}, role_, infinite_) || !is_possible(found.survey))
      throw Error(ExitCode::input, nonsense(*file_, "values are not finite, or negative"));
    if (survey) *survey = *survey + found.survey;
    values += floats;
    leaves = leaves.subspan(some.size());
  }
}

}  // namespace psivox::vdb
