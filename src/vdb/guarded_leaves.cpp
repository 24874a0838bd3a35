#include "guarded_leaves.h"

#include <algorithm>
#include <cstring>
#include <utility>
#include <vector>

#include "psivox/error.h"
#include "sanitise.h"

namespace psivox::vdb {

GuardedLeaves::GuardedLeaves(std::unique_ptr<ReaderProcess> process,
                             std::shared_ptr<FileBlocks> file, const Field& field, GridRole role)
    : process_(std::move(process)),
      file_(std::move(file)),
      floats_per_leaf_(kLeafVoxels * static_cast<std::size_t>(field.channels)),
      role_(role) {}

void GuardedLeaves::read(std::span<const std::uint32_t> leaves, float* values) const {
  constexpr std::size_t at_once = 4096;  // 8 MiB of scalars
  const std::lock_guard lock(mutex_);
  while (!leaves.empty()) {
    const auto some = leaves.first(std::min(at_once, leaves.size()));
    const std::size_t floats = some.size() * floats_per_leaf_;
    Packer request;
    request(std::vector(some.begin(), some.end()));
    std::string bytes;
    try {
      const std::string answer =
          process_->ask(MessageKind::leaves, request.text(), /*descriptor=*/-1, /*grid=*/"", {});
      Unpacker unpack(answer);
      unpack(bytes);
      unpack.end();
    } catch (const Error&) {
      throw;
    } catch (const std::exception& error) {
      throw Error(ExitCode::input, nonsense(*file_, error.what()));
    }
    if (bytes.size() != floats * sizeof(float))
      throw Error(ExitCode::input, nonsense(*file_, "another number of values"));
    std::memcpy(values, bytes.data(), bytes.size());
    if (!all_good({values, floats}, role_))
      throw Error(ExitCode::input, nonsense(*file_, "values are not finite, or negative"));
    values += floats;
    leaves = leaves.subspan(some.size());
  }
}

}  // namespace psivox::vdb
