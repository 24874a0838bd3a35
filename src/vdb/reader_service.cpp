#include <array>
#include <memory>
#include <utility>
#include <vector>

#include "grids_module.h"
#include "guard/service.h"
#include "psivox/vdb.h"
#include "reader.h"
#include "reading_messages.h"

namespace psivox {
namespace vdb {
namespace {

guard::Answer answer_to(const Request& request, Reader& reader) {
  using What = Request::What;
  const std::string& grid = request.of.grid;
  switch (request.what) {
    case What::facts:
      return {guard::packed(reader.facts())};
    case What::info:
      return {guard::packed(reader.info(grid, request.values))};
    case What::content:
      return {guard::packed(reader.content(grid))};
    case What::leaves:
      return {guard::packed(reader.leaves(request.of))};
    case What::data:
      break;
  }
  Field field = reader.read(grid, request.of.options);
  guard::Answer answer{guard::packed(field)};
  if (!stays_in_file(field)) answer.blocks = shared_values(std::move(field));
  return answer;
}

/// A reader in a guarded process, of a file and that of values beside it, or null. No byte of the
/// file is looked at before the first request: by then the process is limited.
guard::Service serving(std::vector<guard::OpenFile> files, Progress progress) {
  std::array<std::shared_ptr<FileBlocks>, 2> blocks;
  for (std::size_t n = 0; n < files.size() && n < blocks.size(); ++n)
    blocks[n] = std::make_shared<FileBlocks>(files[n].path, files[n].descriptor.release());
  return [=, reader = std::shared_ptr<Reader>()](std::string_view bytes) mutable {
    Request request;
    guard::unpack(bytes, request);
    if (!reader) reader = open_reader(blocks[0], blocks[1], progress);
    return answer_to(request, *reader);
  };
}

/// Loads the module for all readers. If that fails, each of them says why.
void load_module() {
  try {
    grids_module();
  } catch (const Error&) {
  }
}

constexpr guard::ServerWork reading{load_module, serving};

}  // namespace
}  // namespace vdb

void start_guarded_reading() { guard::start_server(vdb::reading); }

void start_guarded_reading(const std::filesystem::path& server) { guard::start_server(server); }

void serve_guarded_reading() { guard::serve_as_program(vdb::reading); }

}  // namespace psivox
