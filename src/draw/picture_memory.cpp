#include "psivox/picture_file.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>

#include "psivox/error.h"
#include "psivox/text.h"

namespace psivox {
namespace {

/// Memory that this process may use [bytes]: the machine's, the control group's, or the shell's
/// limit, whichever is least.
double usable_memory() {
  double bytes =
      static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY)
    bytes = std::min(bytes, static_cast<double>(limit.rlim_cur));
  for (const char* group :
       {"/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"}) {
    double of_group = 0;
    if (std::ifstream(group) >> of_group) bytes = std::min(bytes, of_group);
  }
  return bytes;
}

}  // namespace

void check_picture_memory(int width, int height, int layers, int code_bytes) {
  const double pixel = 4 * (4 + layers) + code_bytes;
  const double needed = pixel * width * height, usable = usable_memory();
  if (needed <= usable) return;
  throw Error(ExitCode::memory,
              formatted("a picture of %dx%d takes %.1f GiB of memory, and there are %.1f GiB; give "
                        "a smaller --resolution",
                        width, height, needed / 0x1p30, usable / 0x1p30));
}

}  // namespace psivox
