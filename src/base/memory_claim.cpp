#include "base/memory_claim.h"

#include <atomic>

#include "base/memory.h"
#include "base/text.h"
#include "psivox/error.h"

namespace psivox {
namespace {

std::atomic<std::uint64_t> limit = 0;

}  // namespace

void limit_claims(std::uint64_t bytes) { limit = bytes; }

void claim_memory(double bytes, const std::string& what) {
  const auto refuse = [&](const char* most, std::uint64_t there) {
    throw Error(ExitCode::memory,
                what + formatted(" takes %.1f MiB of memory, and %s %s", bytes / (1 << 20), most,
                                 mebibytes(there).c_str()));
  };
  constexpr double small = 1 << 20;  // looking takes longer
  if (bytes <= small) return;
  const std::uint64_t allowed = limit;
  if (allowed > 0 && bytes > double(allowed)) refuse("--memory-limit allows", allowed);
  const std::uint64_t free = available_memory();
  if (free > 0 && bytes > double(free)) refuse("free are", free);
}

}  // namespace psivox
