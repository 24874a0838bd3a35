#include "base/loaded_module.h"

#include <dlfcn.h>

#include <filesystem>

namespace psivox {

namespace {

/// Whether another library replaces the C library's memory: a sanitizer, an allocator of the
/// user's. A module that finds its own symbols first would free what it did not allocate.
bool memory_is_replaced() {
  Dl_info allocates{}, starts{};
  return dladdr(dlsym(RTLD_DEFAULT, "malloc"), &allocates) == 0 ||
         dladdr(dlsym(RTLD_DEFAULT, "fork"), &starts) == 0 ||
         allocates.dli_fbase != starts.dli_fbase;
}

int flags_of(ModuleScope scope) {
  if (scope == ModuleScope::shared) return RTLD_GLOBAL;
#ifdef RTLD_DEEPBIND
  if (scope == ModuleScope::own_first && !memory_is_replaced()) return RTLD_LOCAL | RTLD_DEEPBIND;
#endif
  return RTLD_LOCAL;
}

}  // namespace

void* load_symbol(const std::string& module, const char* symbol, ModuleScope scope,
                  std::string& problem) {
  std::filesystem::path path = module;
  Dl_info self{};
  if (dladdr(reinterpret_cast<const void*>(&load_symbol), &self) != 0 && self.dli_fname)
    path = std::filesystem::path(self.dli_fname).parent_path() / "psivox" / module;
  void* const opened = dlopen(path.c_str(), RTLD_LAZY | flags_of(scope));
  void* const found = opened ? dlsym(opened, symbol) : nullptr;
  if (found) return found;
  const char* why = dlerror();
  problem = why ? why : "its symbol is missing";
  return nullptr;
}

}  // namespace psivox
