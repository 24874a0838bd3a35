#pragma once

#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "atlas/atlas.h"
#include "psivox/medium.h"

/// C++'s side of the subset that shaders/ is written in: the names that binding.glsl defines for
/// GLSL, here in double. Structs that take the shader's functions as members live in this
/// namespace.
namespace psivox::glsl {

using glm::abs;
using glm::clamp;
using glm::dot;
using glm::floor;
using glm::max;
using glm::min;
using glm::mix;
using std::exp;
using std::expm1;
using std::log1p;
using std::pow;
using std::sqrt;

using real = double;
using real2 = glm::dvec2;
using real3 = glm::dvec3;
using real4 = glm::dvec4;
using int3 = glm::ivec3;
using uint = std::uint32_t;
using uint4 = glm::uvec4;

}  // namespace psivox::glsl

/// Marks a ray that no longer advanced: the GPU adds it to the opacity that it sends.
inline constexpr int stuck_mark = 4;

/// Entries that a further volume has in the tables (shaders/others.glsl).
inline constexpr int other_entries = 13;

/// X(name, value) for the rows of modes, as MODE_mip and SHOWS_light.
#define PSIVOX_SHADER_MODE(name, ...) PSIVOX_ROW(MODE_##name, Mode::name)
#define PSIVOX_SHADER_SHOWS(name) PSIVOX_ROW(SHOWS_##name, Shows::name)

/// What shaders/ calls the values of C++ enums and constants: X(name, value). GLSL gets them in the
/// text before each program, the march in double as members.
#define PSIVOX_SHADER_CONSTANTS(X)                                                    \
  PSIVOX_MODES(PSIVOX_SHADER_MODE)                                                    \
  PSIVOX_SHOWS(PSIVOX_SHADER_SHOWS)                                                   \
  X(SOURCE_CONSTANT, LuminanceSource::constant)                                       \
  X(SOURCE_DENSITY, LuminanceSource::density)                                         \
  X(SOURCE_SCALAR, LuminanceSource::scalar)                                           \
  X(SOURCE_VECTOR, LuminanceSource::vector)                                           \
  X(SOURCE_TRANSFER, LuminanceSource::transfer)                                       \
  X(NODE_EMPTY, EntryKind::empty)       /* payload: Chebyshev distance to another */  \
  X(NODE_CONSTANT, EntryKind::constant) /* payload: index of the constant */          \
  X(NODE_BRICK, EntryKind::brick)       /* payload: slot */                           \
  X(NODE_CHILD, EntryKind::child)       /* payload: index of the first entry below */ \
  X(PAYLOAD_BITS, entry_payload_bits)   /* of an entry of the page table */           \
  X(PAYLOAD_MASK, (1u << entry_payload_bits) - 1)                                     \
  X(SLOT_BITS, entry_slot_bits) /* of a payload with octants */                       \
  X(SLOT_MASK, (1u << entry_slot_bits) - 1)                                           \
  X(BRICK_CELLS, brick_cells)           /* cells on a side of a brick */              \
  X(BRICK_VALUES, brick_values)         /* values on a side */                        \
  X(BRICK_TEXELS, brick_texels)         /* values of a brick */                       \
  X(CODE_WORDS, code_words)             /* of a brick of the narrowest codes */       \
  X(CODE_WIDTH_BITS, code_width_bits)   /* the bits of a step that tell it */         \
  X(NEXT_X, brick_values* brick_values) /* texels from a value to the next along x */ \
  X(NEXT_Y, brick_values)                                                             \
  X(NEXT_Z, 1)                                                                        \
  X(OTHER_ENTRIES, other_entries) /* of a further volume in the tables */             \
  X(STUCK_MARK, stuck_mark)
