#include "psivox/error.h"
#include "psivox/study.h"

namespace psivox {

void run_psi_study(const std::filesystem::path&, const Progress&) {
  throw Error(ExitCode::failure, "not yet");
}

}  // namespace psivox
