#include "picture_files.h"

#include "error_text.h"
#include "psivox/loaded_module.h"

namespace psivox::image_io {
namespace {

const PictureFiles* load_module(ExitCode if_missing) {
  std::string problem;
  const auto get = reinterpret_cast<GetPictureFiles>(
      load_symbol(PSIVOX_OIIO_MODULE, picture_files_symbol, /*shared=*/false, problem));
  if (get) return get();
  throw Error(if_missing,
              one_line("cannot load the module that reads and writes pictures: " + problem));
}

}  // namespace

const PictureFiles& picture_files(ExitCode if_missing) {
  static const PictureFiles* const loaded = load_module(if_missing);  // tried again if it throws
  return *loaded;
}

}  // namespace psivox::image_io
