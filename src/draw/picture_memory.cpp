#include "psivox/picture_file.h"

#include "psivox/error.h"
#include "psivox/memory.h"
#include "psivox/text.h"

namespace psivox {
void check_picture_memory(int width, int height, int layers, int code_bytes) {
  const double pixel = 4 * (4 + layers) + code_bytes;
  const double needed = pixel * width * height;
  const auto usable = double(available_memory());
  if (usable == 0 || needed <= usable) return;
  throw Error(ExitCode::memory,
              formatted("a picture of %dx%d takes %.1f GiB of memory, and %.1f GiB are free; give "
                        "a smaller --resolution",
                        width, height, needed / 0x1p30, usable / 0x1p30));
}

}  // namespace psivox
