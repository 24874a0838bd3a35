#pragma once

#include <filesystem>
#include <string>

#include "psivox/field.h"

namespace psivox {

/// The names of the processor and the operating system; "unknown" if the machine does not say.
std::string processor_name();
std::string system_name();

/// FNV-1a of the file's bytes, 64 bits in hexadecimal. Throws Error(input).
std::string file_hash(const std::filesystem::path& path);

/// The same of the values of a field's leaves, which are in memory.
std::string values_hash(const Field& field);

}  // namespace psivox
