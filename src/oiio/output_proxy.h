#pragma once

#include <OpenImageIO/filesystem.h>

#include "image/output_file.h"

namespace psivox::oiio {

/// An OutputFile as OpenImageIO writes to it.
class OutputProxy final : public OIIO::Filesystem::IOProxy {
 public:
  /// `name`: of which OpenImageIO takes the extension alone.
  OutputProxy(const char* name, image_io::OutputFile& file)
      : IOProxy(name, IOProxy::Write), file_(file) {}

  const char* proxytype() const override { return "psivox"; }
  std::int64_t tell() override { return file_.tell(); }
  bool seek(std::int64_t offset) override { return file_.seek(offset); }
  std::size_t write(const void* bytes, std::size_t size) override {
    return file_.write({static_cast<const char*>(bytes), size});
  }

 private:
  image_io::OutputFile& file_;
};

}  // namespace psivox::oiio
