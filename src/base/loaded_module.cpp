#include "base/loaded_module.h"

#include <dlfcn.h>

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

std::filesystem::path library_folder() {
  Dl_info self{};
  if (dladdr(reinterpret_cast<const void*>(&library_folder), &self) == 0 || !self.dli_fname)
    return {};
  return std::filesystem::path(self.dli_fname).parent_path();
}

void* load_symbol(const std::string& module, const char* symbol, bool shared,
                  std::string& problem) {
  const std::filesystem::path folder = library_folder();
  const std::filesystem::path path = (folder.empty() ? folder : folder / "psivox") / module;
  void* const opened =
      dlopen(path.c_str(), RTLD_LAZY | (shared ? RTLD_GLOBAL : RTLD_LOCAL | own_first()));
  void* const found = opened ? dlsym(opened, symbol) : nullptr;
  if (found) return found;
  const char* why = dlerror();
  problem = why ? why : "its symbol is missing";
  return nullptr;
}

}  // namespace psivox
