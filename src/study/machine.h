#pragma once

#include <filesystem>
#include <string>

namespace psivox {

/// The processor's name and the operating system's, as the machine gives them; "unknown" else.
std::string processor_name();
std::string system_name();

/// FNV-1a of the file's bytes, 64 bits in hexadecimal. Throws Error(input).
std::string file_hash(const std::filesystem::path& path);

}  // namespace psivox
