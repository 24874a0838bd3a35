#pragma once

#include <cstdint>

namespace psivox {

/// Throws Error(memory) if a picture does not fit into the machine's memory, so that a size that
/// cannot succeed is refused before the volume is read.
///
/// `layers`: one number a pixel each; `code_bytes`: of a pixel as its file encodes it.
void check_picture_memory(int width, int height, int layers, int code_bytes);

}  // namespace psivox
