#include "vdb/shared_reader.h"

#include <filesystem>
#include <map>
#include <string>
#include <utility>

#include "scan/scan.h"

namespace psivox::vdb {
namespace {

std::shared_ptr<SharedReader> opened(const std::filesystem::path& path, Progress progress) {
  auto shared = std::make_shared<SharedReader>(std::make_shared<FileBlocks>(path));
  shared->progress = std::move(progress);
  std::shared_ptr<FileBlocks> data;
  if (const std::string beside = scan::data_path(*shared->file); !beside.empty())
    data = std::make_shared<FileBlocks>(std::filesystem::path(beside));
  const Progress report = [of = shared.get()](double done) {
    if (of->progress) of->progress(done);
  };
  shared->reader = open_guarded_reader(shared->file, data, report);
  if (!shared->reader) shared->reader = open_reader(shared->file, data, report);
  return shared;
}

}  // namespace

Turn::Turn(SharedReader& shared, Progress& own) : lock_(shared.mutex), shared_(shared), own_(own) {
  std::swap(shared_.progress, own_);
}

Turn::~Turn() { std::swap(shared_.progress, own_); }

std::shared_ptr<SharedReader> reader_of(const FrameOfFile& one, Progress progress) {
  static std::mutex mutex;
  static std::map<std::string, std::weak_ptr<SharedReader>> open;  // by path and stamp
  const std::string key = one.file.string() + "\n" + file_stamp(one.file);
  if (!one.frame.empty()) {
    const std::lock_guard lock(mutex);
    if (const auto known = open.find(key); known != open.end())
      if (auto shared = known->second.lock()) return shared;
  }
  auto shared = opened(one.file, one.frame.empty() ? std::move(progress) : Progress());
  const std::lock_guard lock(mutex);
  std::erase_if(open, [](const auto& item) { return item.second.expired(); });
  open[key] = shared;
  return shared;
}

}  // namespace psivox::vdb
