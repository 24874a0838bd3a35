// libFuzzer's side: PSIVOX_FUZZ_TARGET in the environment names the target.

#include <cstdint>
#include <cstdlib>

#include "targets.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  static const char* const target = std::getenv("PSIVOX_FUZZ_TARGET");
  psivox::fuzz::run(target ? target : "", {reinterpret_cast<const char*>(bytes), size});
  return 0;
}
