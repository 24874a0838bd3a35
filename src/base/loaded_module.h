#pragma once

#include <filesystem>
#include <string>

namespace psivox {

/// The folder of libpsivox; empty if the system does not tell.
std::filesystem::path library_folder();

/// A symbol of a module, a file of the folder `psivox` beside libpsivox; null with `problem` set if
/// it cannot be loaded. The module stays loaded. `shared`: its symbols are for other modules too.
void* load_symbol(const std::string& module, const char* symbol, bool shared, std::string& problem);

}  // namespace psivox
