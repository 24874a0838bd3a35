#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <memory>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "base/memory.h"
#include "grids_module.h"
#include "guard/service.h"
#include "psivox/vdb.h"
#include "reader.h"
#include "reading_messages.h"
#include "survey.h"

namespace psivox {
namespace vdb {
namespace {

/// A reader in a guarded process.
class ReaderService final : public guard::Service {
 public:
  ReaderService(std::string path, guard::Descriptor file, Progress progress)
      : file_(std::make_shared<FileBlocks>(std::move(path), file.release())),
        progress_(std::move(progress)) {}

  std::string answer(std::string_view bytes, int descriptor) override {
    Request request;
    guard::unpack(bytes, request);
    return std::visit(
        [&](const auto& known) { return guard::packed(answer_to(known, descriptor)); }, request);
  }

 private:
  /// No byte of the file is looked at before the first request: by then the process is limited.
  Reader& reader() {
    if (!reader_) reader_ = open_reader(file_, data_, progress_);
    return *reader_;
  }

  std::string answer_to(const DataRequest& request, int descriptor) {
    const int copy = dup(descriptor);
    if (copy < 0) throw std::system_error(errno, std::generic_category());
    data_ = std::make_shared<FileBlocks>(request.path, copy, request.size);
    return {};
  }
  FileFacts answer_to(const FactsRequest&, int) { return reader().facts(); }
  std::vector<GridInfo> answer_to(const InfoRequest& request, int) {
    return reader().info(request.grid, request.values);
  }
  GridContent answer_to(const ContentRequest& request, int) {
    return reader().content(request.grid);
  }

  /// Keeps the last field, so that the reader keeps its values.
  FieldFacts answer_to(const ReadRequest& request, int memory) {
    Field field = reader().read(request.grid, request.options);
    FieldFacts facts;
    facts.leaves = field.leaves.size();
    facts.tiles = field.tiles.size();
    if (field.reader) facts.active_tiles = field.reader->active_tiles();
    facts.same_values = request.holds_last && shares_values(field, last_);
    if (!facts.same_values) write_places(field, memory, facts);
    last_ = std::move(field);
    if (last_.reader) last_.leaves = {};  // its reader knows their places
    facts.field = last_;
    return facts;
  }

  std::string answer_to(const ValuesRequest& request, int memory) const {
    return write_values(last_, request, memory);
  }

  LeavesAnswer answer_to(const LeavesRequest& request, int) const {
    if (!last_.reader) throw std::runtime_error("an unknown request");
    LeavesAnswer answer;
    answer.values.resize(request.numbers.size() * kLeafVoxels *
                         static_cast<std::size_t>(last_.channels) * sizeof(float));
    answer.survey = last_.reader->read(
        request.numbers, reinterpret_cast<float*>(answer.values.data()), request.what);
    return answer;
  }

  /// A notice would tell that values were changed.
  static bool shares_values(const Field& a, const Field& b) {
    return a.storage && a.storage == b.storage && a.notices.empty() && b.notices.empty() &&
           std::ranges::equal(a.tiles, b.tiles, [](const Tile& x, const Tile& y) {
             return x.origin == y.origin && x.width == y.width && x.value == y.value;
           });
  }

  LargePages pages_;
  std::shared_ptr<FileBlocks> file_, data_;
  Progress progress_;
  std::unique_ptr<Reader> reader_;
  Field last_;
};

/// Loads the module for all readers. If that fails, each of them says why.
void load_module() {
  try {
    grids_module();
  } catch (const Error&) {
  }
}

constexpr guard::Trade reading{load_module,
                               [](std::string path, guard::Descriptor file,
                                  Progress progress) -> std::unique_ptr<guard::Service> {
                                 return std::make_unique<ReaderService>(
                                     std::move(path), std::move(file), std::move(progress));
                               }};

}  // namespace
}  // namespace vdb

void start_guarded_reading() { guard::start_server(vdb::reading); }

void start_guarded_reading(const std::filesystem::path& server) { guard::start_server(server); }

void serve_guarded_reading() { guard::serve_as_program(vdb::reading); }

}  // namespace psivox
