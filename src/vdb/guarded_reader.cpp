#include "guarded_reader.h"

#include <stdexcept>
#include <utility>

#include "check_field.h"
#include "guarded_leaves.h"
#include "psivox/error.h"
#include "shared_field.h"
#include "subject.h"

namespace psivox::vdb {

GuardedReader::GuardedReader(std::shared_ptr<FileBlocks> file, Progress progress)
    : file_(std::move(file)), progress_(std::move(progress)) {}

template <typename Take>
void GuardedReader::ask(MessageKind kind, const std::string& content, int descriptor,
                        const std::string& grid, const Take& take) {
  try {
    if (!process_) {
      last_storage_.reset();
      process_ = std::make_unique<ReaderProcess>(file_);
      if (kind != MessageKind::open)
        process_->ask(MessageKind::open, file_->path(), file_->descriptor(), "", {});
    }
    const std::string answer = process_->ask(kind, content, descriptor, grid, progress_);
    Unpacker unpack(answer);
    take(unpack);
    unpack.end();
  } catch (const Error&) {
    process_.reset();
    throw;
  } catch (const std::exception& error) {
    process_.reset();
    throw Error(ExitCode::input, nonsense(*file_, error.what()));
  } catch (...) {  // the progress ends the reading
    process_.reset();
    throw;
  }
}

FileFacts GuardedReader::facts() {
  const std::lock_guard lock(mutex_);
  FileFacts facts;
  ask(MessageKind::open, file_->path(), file_->descriptor(), "", [&](Unpacker& answer) {
    answer(facts);
    const std::size_t grids = facts.names.size();
    if (facts.base_names.size() != grids || facts.channels.size() != grids ||
        facts.value_types.size() != grids || facts.classes.size() != grids)
      throw std::runtime_error("lists of different lengths");
  });
  facts_ = facts;
  return facts;
}

std::vector<GridInfo> GuardedReader::rows(const std::string& grid, bool values) {
  Packer request;
  request(grid, values);
  std::vector<GridInfo> rows;
  ask(MessageKind::info, request.text(), -1, grid, [&](Unpacker& answer) { answer(rows); });
  return rows;
}

GridInfo GuardedReader::row(const std::string& grid, bool values) {
  const std::vector<GridInfo> answer = rows(grid, values);
  if (answer.size() != 1) throw Error(ExitCode::input, nonsense(*file_, "another number of rows"));
  return answer.front();
}

std::vector<GridInfo> GuardedReader::info(bool values) {
  const std::lock_guard lock(mutex_);
  try {
    return rows("", values);
  } catch (const Error& error) {
    if (error.code() != ExitCode::input) throw;
  }
  // a grid ended the reader: each is asked for by itself, until several have ended theirs, which
  // may take the time that an answer has
  constexpr int most_ends = 2;
  int ends = 0;
  std::vector<GridInfo> all;
  for (std::size_t i = 0; i < facts_.names.size(); ++i) {
    GridInfo row;
    row.name = facts_.names[i];
    row.channels = facts_.channels[i];
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

GridContent GuardedReader::content(const std::string& grid) {
  const std::lock_guard lock(mutex_);
  Packer request;
  request(grid);
  GridContent content;
  ask(MessageKind::content, request.text(), -1, grid, [&](Unpacker& answer) { answer(content); });
  return content;
}

Field GuardedReader::read(const std::string& grid, const ReadOptions& options) {
  const std::lock_guard lock(mutex_);
  const std::shared_ptr<const void> held = last_storage_.lock();
  const Descriptor memory = shared_memory();
  Packer request;
  request(ReadRequest{grid, options, held != nullptr});
  FieldFacts facts;
  ask(MessageKind::read, request.text(), memory.get(), grid, [&](Unpacker& answer) {
    answer(facts);
    Field& field = facts.field;
    if (facts.same_values) {
      if (!held || facts.leaves != last_.leaves.size() || facts.tiles != last_.tiles.size() ||
          field.channels != last_.channels)
        throw std::runtime_error("values that it has not sent");
      field.leaves = last_.leaves;
      field.tiles = last_.tiles;
      field.storage = held;
    } else {
      take_shared(facts, memory.get());
    }
    check_field(facts, options.role);
  });
  // from now on that process reads leaves
  if (facts.stored)
    facts.field.reader =
        std::make_shared<GuardedLeaves>(std::move(process_), file_, facts, options.role);
  last_ = facts.field;
  last_storage_ = last_.storage;
  last_.storage.reset();
  return facts.field;
}

}  // namespace psivox::vdb
