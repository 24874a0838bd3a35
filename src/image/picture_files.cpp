#include "picture_files.h"

#include <dlfcn.h>

#include "error_text.h"

namespace psivox::image_io {
namespace {

/// The module lies in a folder beside the library that this function is in.
std::filesystem::path module_path() {
  Dl_info self{};
  if (dladdr(reinterpret_cast<const void*>(&read_image), &self) == 0 || !self.dli_fname)
    return PSIVOX_OIIO_MODULE;
  return std::filesystem::path(self.dli_fname).parent_path() / "psivox" / PSIVOX_OIIO_MODULE;
}

const PictureFiles* load_module(ExitCode if_missing) {
  // Never closed: OpenImageIO has threads.
  void* module = dlopen(module_path().c_str(), RTLD_LAZY | RTLD_LOCAL);
  const auto get =
      reinterpret_cast<GetPictureFiles>(module ? dlsym(module, picture_files_symbol) : nullptr);
  if (get) return get();
  const char* why = dlerror();
  throw Error(if_missing, one_line("cannot load the module that reads and writes pictures: " +
                                   std::string(why ? why : "its symbol is missing")));
}

}  // namespace

const PictureFiles& picture_files(ExitCode if_missing) {
  static const PictureFiles* const loaded = load_module(if_missing);  // tried again if it throws
  return *loaded;
}

}  // namespace psivox::image_io
