#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

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
    FieldFacts facts{.field = reader().read(request.grid, request.options)};
    leaves_ = facts.field.reader;
    channels_ = facts.field.channels;
    if (leaves_) facts.active_tiles = leaves_->active_tiles();
    Answer answer{guard::packed(facts)};
    if (!facts.stored()) answer.blocks = shared_values(std::move(facts.field));
    return answer;
  }

  Answer answer_to(const LeavesRequest& request) const {
    if (!leaves_) throw std::runtime_error("an unknown request");
    LeavesAnswer answer;
    answer.values.resize(request.numbers.size() * kLeafVoxels *
                         static_cast<std::size_t>(channels_) * sizeof(float));
    answer.survey = leaves_->read(request.numbers, reinterpret_cast<float*>(answer.values.data()),
                                  request.what);
    return {guard::packed(answer)};
  }

  std::vector<std::shared_ptr<FileBlocks>> files_;  ///< and that of values beside it, or null
  Progress progress_;
  std::unique_ptr<Reader> reader_;
  std::shared_ptr<const LeafReader> leaves_;  ///< of the last field, if they stay in the file
  int channels_ = 0;                          ///< of that field
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
