#pragma once

#include <dlfcn.h>

#include <filesystem>
#include <string>

namespace psivox {

/// A symbol of a module, a file of the folder `psivox` beside libpsivox; null with `problem` set if
/// it cannot be loaded. The module stays loaded. `shared`: its symbols are for other modules too.
inline void* load_symbol(const std::string& module, const char* symbol, bool shared,
                         std::string& problem) {
  std::filesystem::path path = module;
  Dl_info self{};
  if (dladdr(reinterpret_cast<const void*>(&load_symbol), &self) != 0 && self.dli_fname)
    path = std::filesystem::path(self.dli_fname).parent_path() / "psivox" / module;
  void* const opened = dlopen(path.c_str(), RTLD_LAZY | (shared ? RTLD_GLOBAL : RTLD_LOCAL));
  void* const found = opened ? dlsym(opened, symbol) : nullptr;
  if (found) return found;
  const char* why = dlerror();
  problem = why ? why : "its symbol is missing";
  return nullptr;
}

}  // namespace psivox
