#include <memory>
#include <utility>
#include <vector>

#include "field/leaf_values.h"
#include "grids_module.h"
#include "guard/service.h"
#include "psivox/vdb.h"
#include "reader.h"
#include "reading_messages.h"

namespace psivox {
namespace vdb {
namespace {

/// A reader in a guarded process.
class ReaderService final : public guard::Service {
 public:
  ReaderService(std::vector<guard::OpenFile> files, Progress progress)
      : progress_(std::move(progress)) {
    for (guard::OpenFile& file : files)
      files_.push_back(
          std::make_shared<FileBlocks>(std::move(file.path), file.descriptor.release()));
    files_.resize(2);
  }

  Answer answer(std::string_view bytes) override {
    Request request;
    guard::unpack(bytes, request);
    return std::visit([&](const auto& known) { return answer_to(known); }, request);
  }

 private:
  /// No byte of the file is looked at before the first request: by then the process is limited.
  Reader& reader() {
    if (!reader_) reader_ = open_reader(files_[0], files_[1], progress_);
    return *reader_;
  }

  Answer answer_to(const FactsRequest&) { return {guard::packed(reader().facts())}; }
  Answer answer_to(const InfoRequest& request) {
    return {guard::packed(reader().info(request.grid, request.values))};
  }
  Answer answer_to(const ContentRequest& request) {
    return {guard::packed(reader().content(request.grid))};
  }

  Answer answer_to(const ReadRequest& request) {
    Field field = reader().read(request.grid, request.options);
    Answer answer{guard::packed(field)};
    if (!stays_in_file(field)) answer.blocks = shared_values(std::move(field));
    return answer;
  }
  Answer answer_to(const LeavesRequest& request) {
    return {guard::packed(reader().leaves(request))};
  }

  std::vector<std::shared_ptr<FileBlocks>> files_;  ///< and that of values beside it, or null
  Progress progress_;
  std::unique_ptr<Reader> reader_;
};

/// Loads the module for all readers. If that fails, each of them says why.
void load_module() {
  try {
    grids_module();
  } catch (const Error&) {
  }
}

constexpr guard::Trade reading{
    load_module,
    [](std::vector<guard::OpenFile> files, Progress progress) -> std::unique_ptr<guard::Service> {
      return std::make_unique<ReaderService>(std::move(files), std::move(progress));
    }};

}  // namespace
}  // namespace vdb

void start_guarded_reading() { guard::start_server(vdb::reading); }

void start_guarded_reading(const std::filesystem::path& server) { guard::start_server(server); }

void serve_guarded_reading() { guard::serve_as_program(vdb::reading); }

}  // namespace psivox
