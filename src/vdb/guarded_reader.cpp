#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <utility>

#include "base/memory.h"
#include "field/leaf_values.h"
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
    Field field = ask(ReadRequest{grid, options},
                      [&](Field answer, const std::vector<guard::SealedMemory>& blocks) {
                        if (!blocks.empty()) take_values(answer, blocks);
                        check_field(answer, options);
                        return answer;
                      });
    budget_->deliver(value_bytes(field));
    return field;
  }

  std::vector<float> leaves(const LeavesWish& wish) override {
    const std::lock_guard lock(mutex_);
    std::vector<float> values =
        ask(LeavesRequest{wish}, [&](std::vector<float> answer, const auto&) {
          const std::size_t count = wish.numbers.size() * kLeafVoxels;
          if (answer.size() != count && answer.size() != 3 * count)
            throw std::runtime_error("another number of values");
          if (!all_good(answer, wish.options.role, wish.options.absent))
            throw std::runtime_error("values are not finite, or negative");
          return answer;
        });
    budget_->deliver(values.size() * sizeof(float));
    return values;
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
