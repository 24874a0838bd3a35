#include "picture_files.h"

#include <dlfcn.h>

#include "error_text.h"
#include "psivox/error.h"

namespace psivox {
namespace {

/// The module lies beside the library that this function is in.
std::filesystem::path module_path() {
  Dl_info self{};
  if (dladdr(reinterpret_cast<const void*>(&read_image), &self) == 0 || !self.dli_fname)
    return PSIVOX_OIIO_MODULE;
  return std::filesystem::path(self.dli_fname).parent_path() / PSIVOX_OIIO_MODULE;
}

const image_io::PictureFiles* load_module() {
  const std::filesystem::path path = module_path();
  const auto fail = [&]() -> Error {
    const char* why = dlerror();
    return {
        ExitCode::failure,
        image_io::one_line("cannot load what reads pictures: " +
                           std::string(why ? why : "'" + path.string() + "' is no such module"))};
  };
  // Never closed: OpenImageIO has threads.
  void* module = dlopen(path.c_str(), RTLD_LAZY | RTLD_LOCAL);
  if (!module) throw fail();
  const auto get =
      reinterpret_cast<image_io::GetPictureFiles>(dlsym(module, image_io::picture_files_symbol));
  if (!get) throw fail();
  return get();
}

const image_io::PictureFiles& files() {
  static const image_io::PictureFiles* const loaded = load_module();
  return *loaded;
}

}  // namespace

Image read_image(const std::filesystem::path& path) { return files().read_image(path); }

std::string read_metadata(const std::filesystem::path& path, const std::string& key) {
  return files().read_metadata(path, key);
}

std::string openimageio_version() { return files().version(); }

}  // namespace psivox
