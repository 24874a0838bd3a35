#include "base/loaded_module.h"

#include <dlfcn.h>

#include <filesystem>

namespace psivox {
namespace {

/// A flag by which a module's libraries look for symbols among themselves first: one of so many
/// symbols as OpenVDB loads in four fifths of the time. Sanitizers refuse it.
int own_first() {
#ifdef RTLD_DEEPBIND
  if (!dlsym(RTLD_DEFAULT, "__sanitizer_print_stack_trace")) return RTLD_DEEPBIND;
#endif
  return 0;
}

}  // namespace

void* load_symbol(const std::string& module, const char* symbol, bool shared,
                  std::string& problem) {
  std::filesystem::path path = module;
  Dl_info self{};
  if (dladdr(reinterpret_cast<const void*>(&load_symbol), &self) != 0 && self.dli_fname)
    path = std::filesystem::path(self.dli_fname).parent_path() / "psivox" / module;
  void* const opened =
      dlopen(path.c_str(), RTLD_LAZY | (shared ? RTLD_GLOBAL : RTLD_LOCAL | own_first()));
  void* const found = opened ? dlsym(opened, symbol) : nullptr;
  if (found) return found;
  const char* why = dlerror();
  problem = why ? why : "its symbol is missing";
  return nullptr;
}

}  // namespace psivox
