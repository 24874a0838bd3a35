#include <atomic>
#include <functional>
#include <mutex>
#include <stdexcept>
#include <type_traits>
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
    auto facts = ask<FileFacts>({Request::What::facts});
    budget_->claim(facts.value_bytes);
    return facts;
  }

  GridInfo info(const std::string& grid, bool values) override {
    const std::lock_guard lock(mutex_);
    return ask<GridInfo>({Request::What::info, {grid}, values});
  }

  GridContent content(const std::string& grid) override {
    const std::lock_guard lock(mutex_);
    return ask<GridContent>({Request::What::content, {grid}});
  }

  Field read(const std::string& grid, const ReadOptions& options) override {
    const std::lock_guard lock(mutex_);
    Field field = ask<Field>({Request::What::data, {grid, options}},
                             [&](Field& answer, const std::vector<guard::SealedMemory>& blocks) {
                               if (!blocks.empty()) take_values(answer, blocks);
                               check_field(answer, options);
                             });
    budget_->deliver(value_bytes(field));
    return field;
  }

  std::vector<float> leaves(const LeavesWish& wish) override {
    const std::lock_guard lock(mutex_);
    auto values = ask<std::vector<float>>(
        {Request::What::leaves, wish}, [&](const std::vector<float>& answer, const auto&) {
          const std::size_t count = wish.numbers.size() * kLeafVoxels;
          if (answer.size() != count && answer.size() != 3 * count)
            throw std::runtime_error("another number of values");
          if (!all_good(answer, wish.options.role, wish.options.absent))
            throw std::runtime_error("values are not finite, or negative");
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

  /// The answer to a request, which `check` has seen with its blocks. If that throws, or the
  /// process answers nonsense, it is ended; not if it answers with an Error.
  template <typename Answer>
  Answer ask(const Request& request,
             const std::type_identity_t<
                 std::function<void(Answer&, std::vector<guard::SealedMemory>&)>>& check = {}) {
    auto process = process_ ? std::move(process_) : started();
    try {
      guard::SealedAnswer sealed =
          process->ask(guard::packed(request), subject(file_->path(), request.of.grid), progress_);
      Answer answer;
      guard::unpack(sealed.text, answer);
      if (check) check(answer, sealed.blocks);
      process_ = std::move(process);
      return answer;
    } catch (const Error&) {
      if (process->is_intact()) process_ = std::move(process);
      throw;
    } catch (const std::exception& error) {
      // the file may be in order
      if (dynamic_cast<const std::bad_alloc*>(&error) || lacks_threads(error)) throw;
      throw Error(ExitCode::input,
                  file_->path() + ": is damaged: its reader answered nonsense: " + error.what());
    }
  }

  std::shared_ptr<FileBlocks> file_, data_;
  Progress progress_;
  std::shared_ptr<guard::Budget> budget_;
  std::mutex mutex_;  ///< of what follows: one request at a time
  std::unique_ptr<guard::Process> process_;
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
