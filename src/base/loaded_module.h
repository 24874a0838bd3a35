#pragma once

#include <string>

namespace psivox {

/// Where a module's symbols are looked for.
enum class ModuleScope {
  program_first,  ///< in the program's libraries, then in its own
  own_first,      ///< in its own: OpenVDB's 69,000 are found in 8 ms less
  shared,         ///< as program_first, and its symbols are for other modules too
};

/// A symbol of a module, a file of the folder `psivox` beside libpsivox; null with `problem` set if
/// it cannot be loaded. The module stays loaded.
void* load_symbol(const std::string& module, const char* symbol, ModuleScope scope,
                  std::string& problem);

}  // namespace psivox
