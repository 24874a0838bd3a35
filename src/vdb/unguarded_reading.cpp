// Reading without PSIVOX_GUARD: every file is read in this process, as --trust does.

#include <atomic>
#include <cstdlib>

#include "psivox/vdb.h"
#include "reader.h"

namespace psivox {

namespace {
std::atomic<bool> demands_guard = false;
}

std::unique_ptr<vdb::Reader> vdb::open_guarded_reader(std::shared_ptr<FileBlocks> file,
                                                      std::shared_ptr<FileBlocks>, Progress) {
  if (demands_guard)
    throw Error(ExitCode::input, file->path() +
                                     ": is not read: psivox was built without "
                                     "PSIVOX_GUARD, which --trust=no demands");
  return {};
}

void start_guarded_reading() {}
void start_guarded_reading(const std::filesystem::path&) {}
void serve_guarded_reading() { std::exit(1); }
void trust_files(Trust trust) { demands_guard = trust == Trust::no; }

std::string reading_guard() { return "nothing: psivox was built without PSIVOX_GUARD"; }

}  // namespace psivox
