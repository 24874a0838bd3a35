#include "base/loaded_module.h"

#include <dlfcn.h>

namespace psivox {
namespace {

/// A flag by which a module's libraries look for symbols among themselves first: one of so many
/// symbols as OpenVDB loads in four fifths of the time. Sanitizers refuse it. A program that was
/// compiled without -fPIC has its own copy of libstdc++'s data, which is the one in use, and which
/// these libraries would not find: OpenVDB of gcc 13 and later crashes.
int own_first() {
#ifdef RTLD_DEEPBIND
  constexpr const char* datum = "_ZNSt5ctypeIcE2idE";  // std::ctype<char>::id
  void* const library = dlopen("libstdc++.so.6", RTLD_LAZY | RTLD_NOLOAD);
  const void* const used = dlsym(RTLD_DEFAULT, datum);
  const bool copied = used && (!library || used != dlsym(library, datum));
  if (!copied && !dlsym(RTLD_DEFAULT, "__sanitizer_print_stack_trace")) return RTLD_DEEPBIND;
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
