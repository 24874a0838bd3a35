#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <mutex>
#include <optional>
#include <stdexcept>
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

Error nonsense(const FileBlocks& file, const std::string& what) {
  return Error(ExitCode::input,
               file.path() + ": is damaged: its reader answered nonsense: " + what);
}

/// Whether this process lacks memory or threads: the file may be in order.
bool is_of_this_process(const std::exception& error) {
  return dynamic_cast<const std::bad_alloc*>(&error) || lacks_threads(error);
}

/// What take() makes of the answer of a process and its blocks. Throws Error(input), also if the
/// answer is nonsense.
template <typename R, typename Take>
auto ask_process(guard::Process& process, const FileBlocks& file, const R& request,
                 const Progress& progress, const Take& take) {
  try {
    const guard::SealedAnswer sealed =
        process.ask(guard::packed(Request(request)), subject(file.path(), request.grid), progress);
    typename R::Answer answer;
    guard::unpack(sealed.text, answer);
    return take(std::move(answer), sealed.blocks);
  } catch (const Error&) {
    throw;
  } catch (const std::exception& error) {
    if (is_of_this_process(error)) throw;
    throw nonsense(file, error.what());
  }
}

constexpr auto as_it_is = [](auto answer, const auto&) { return answer; };

/// Leaves whose values stay in the file, read by the process that has read the field.
class GuardedLeaves final : public LeafReader {
 public:
  GuardedLeaves(std::unique_ptr<guard::Process> process, std::shared_ptr<FileBlocks> file,
                std::shared_ptr<guard::Budget> budget, const FieldFacts& facts, GridRole role)
      : process_(std::move(process)),
        file_(std::move(file)),
        budget_(std::move(budget)),
        floats_per_leaf_(kLeafVoxels * static_cast<std::size_t>(facts.field.channels)),
        role_(role),
        active_tiles_(facts.active_tiles) {}

  ValueSurvey read(std::span<const std::uint32_t> leaves, float* values,
                   LeafRead what) const override {
    constexpr std::size_t at_once = 4096;  // 8 MiB of scalars
    const std::lock_guard lock(mutex_);
    ValueSurvey found;
    for (; !leaves.empty(); leaves = leaves.subspan(std::min(at_once, leaves.size()))) {
      const auto some = leaves.first(std::min(at_once, leaves.size()));
      const std::span to(values, some.size() * floats_per_leaf_);
      const LeavesRequest request{.numbers = {some.begin(), some.end()}, .what = what};
      found = found + ask_process(*process_, *file_, request, {},
                                  [&](const LeavesAnswer& got, const auto&) {
                                    take(got, to, what == LeafRead::active);
                                    return got.survey;
                                  });
      budget_->deliver(to.size_bytes());
      values += to.size();
    }
    return found;
  }
  const std::vector<TileValue>& active_tiles() const override { return active_tiles_; }

 private:
  /// Throws std::runtime_error if the answer is nonsense. `active`: values may be NaN.
  void take(const LeavesAnswer& answer, std::span<float> values, bool active) const {
    if (answer.values.size() != values.size_bytes())
      throw std::runtime_error("another number of values");
    std::memcpy(values.data(), answer.values.data(), answer.values.size());
    std::vector<float> known(values.begin(), active ? values.end() : values.begin());
    for (float& value : known)
      if (std::isnan(value)) value = 0;
    if (!all_good(active ? known : values, role_, /*infinite=*/true) || !is_possible(answer.survey))
      throw std::runtime_error("values are not finite, or negative");
  }

  mutable std::mutex mutex_;  ///< of the process
  std::unique_ptr<guard::Process> process_;
  std::shared_ptr<FileBlocks> file_;
  std::shared_ptr<guard::Budget> budget_;
  std::size_t floats_per_leaf_;
  GridRole role_;
  std::vector<TileValue> active_tiles_;
};

/// Reads in a process of its own, which answers as open_reader's reader does. If the process ends,
/// the next call starts another one.
class GuardedReader final : public Reader {
 public:
  /// `data`: as open_reader takes it.
  GuardedReader(std::shared_ptr<FileBlocks> file, std::shared_ptr<FileBlocks> data,
                Progress progress)
      : file_(std::move(file)),
        data_(std::move(data)),
        progress_(std::move(progress)),
        budget_(std::make_shared<guard::Budget>(file_->size() + (data_ ? data_->size() : 0))) {}

  FileFacts facts() override {
    const std::lock_guard lock(mutex_);
    facts_ = ask(FactsRequest());
    budget_->claim(facts_.value_bytes);
    return facts_;
  }

  std::vector<GridInfo> info(const std::string& grid, bool values) override {
    const std::lock_guard lock(mutex_);
    if (!grid.empty()) return {row(grid, values)};
    try {
      return ask(InfoRequest{grid, values});
    } catch (const Error& error) {
      if (error.code() != ExitCode::input) throw;
    }
    // a grid ended the reader: each is asked for by itself, until several have ended theirs, which
    // may take the time that an answer has
    constexpr int most_ends = 2;
    int ends = 0;
    std::vector<GridInfo> all;
    for (const GridFacts& grid_facts : facts_.grids) {
      GridInfo row;
      row.name = grid_facts.name;
      row.channels = grid_facts.channels;
      row.problem = "was not read, because reading other grids failed";
      try {
        if (ends < most_ends) row = this->row(row.name, values);
      } catch (const Error& error) {
        if (error.code() != ExitCode::input) throw;
        row.problem = without_subject(error.what(), file_->path(), row.name);
        ++ends;
      }
      all.push_back(row);
    }
    return all;
  }

  GridContent content(const std::string& grid) override {
    const std::lock_guard lock(mutex_);
    return ask(ContentRequest{grid});
  }

  Field read(const std::string& grid, const ReadOptions& options) override {
    const std::lock_guard lock(mutex_);
    FieldFacts facts = ask(ReadRequest{grid, options},
                           [&](FieldFacts answer, const std::vector<guard::SealedMemory>& blocks) {
                             if (!answer.stored()) take_values(answer.field, blocks);
                             check_field(answer, options.role);
                             return answer;
                           });
    budget_->deliver(facts.field.leaves.size() * kLeafVoxels *
                     static_cast<std::size_t>(facts.field.channels) * sizeof(float));
    // from now on that process reads leaves, as long as the field is held
    if (facts.stored())
      facts.field.reader =
          std::make_shared<GuardedLeaves>(std::move(process_), file_, budget_, facts, options.role);
    return std::move(facts.field);
  }

 private:
  std::unique_ptr<guard::Process> started() {
    std::vector<guard::SharedFile> files{{file_->path(), file_->descriptor()}};
    if (data_) files.push_back({data_->path(), data_->descriptor()});
    return std::make_unique<guard::Process>(files, budget_, has_grids(*file_));
  }

  /// What take() makes of the answer to a request. What is thrown ends the process, but for an
  /// Error that the process answers with.
  template <typename R, typename Take = decltype(as_it_is)>
  typename R::Answer ask(const R& request, const Take& take = as_it_is) {
    auto process = process_ ? std::move(process_) : started();
    try {
      auto answer = ask_process(*process, *file_, request, progress_, take);
      process_ = std::move(process);
      return answer;
    } catch (const Error&) {
      if (process->is_intact()) process_ = std::move(process);
      throw;
    }
  }

  GridInfo row(const std::string& grid, bool values) {
    return ask(InfoRequest{grid, values},
               [](std::vector<GridInfo> rows, const auto&) {
                 if (rows.size() != 1) throw std::runtime_error("another number of rows");
                 return rows;
               })
        .front();
  }

  std::shared_ptr<FileBlocks> file_, data_;
  Progress progress_;
  std::shared_ptr<guard::Budget> budget_;
  std::mutex mutex_;  ///< of what follows: one request at a time
  std::unique_ptr<guard::Process> process_;
  FileFacts facts_;
};

std::atomic<Trust> trust = Trust::if_needed;

bool reads_guarded() { return guard::has_server() && trust != Trust::yes; }

/// Whether the kernel restricts the calls of a process that is started to find out.
bool has_restriction() {
  return guard::Process({}, std::make_shared<guard::Budget>(0), /*prepared=*/false).begin("");
}

}  // namespace

std::unique_ptr<Reader> open_guarded_reader(std::shared_ptr<FileBlocks> file,
                                            std::shared_ptr<FileBlocks> data, Progress progress) {
  if (reads_guarded())
    return std::make_unique<GuardedReader>(std::move(file), std::move(data), std::move(progress));
  if (trust == Trust::no)
    throw Error(ExitCode::input, file->path() +
                                     ": is not read: no guarded process reads files "
                                     "here, as --trust=no demands");
  return {};
}

}  // namespace vdb

void trust_files(Trust trust) {
  vdb::trust = trust;
  guard::demands_restriction = trust == Trust::no;
}

std::string reading_guard() {
  if (!vdb::reads_guarded()) return "nothing";
  return vdb::has_restriction() ? "seccomp and resource limits"
                                : "resource limits, without seccomp";
}

}  // namespace psivox
