#include "reader_service.h"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <exception>
#include <memory>
#include <new>
#include <stdexcept>
#include <utility>
#include <vector>

#include "file_blocks.h"
#include "in_place_reader.h"
#include "psivox/error.h"
#include "psivox/memory.h"
#include "restrict_process.h"
#include "sanitise.h"
#include "shared_field.h"
#include "socket.h"

namespace psivox::vdb {

std::function<void(const std::string& path, const Message& message, int connection)> before_answer;

namespace {

/// An open file, read in this process.
class Service {
 public:
  Service(int connection, std::string path, Descriptor file)
      : connection_(connection),
        file_(std::make_shared<FileBlocks>(std::move(path), file.release())) {}

  /// Answers a message.
  void answer(const Message& message) {
    try {
      if (before_answer) before_answer(file_->path(), message, connection_);
      const std::string content = answer_to(message);
      reply(MessageKind::answer, content);
    } catch (const Error& error) {
      fail(error.code(), error.what());
    } catch (const std::bad_alloc&) {
      fail(ExitCode::input, file_->path() + ": asks for more memory than there is");
    } catch (const std::exception& error) {
      fail(ExitCode::input, file_->path() + ": cannot be read: " + error.what());
    }
  }

 private:
  std::string answer_to(const Message& message) {
    Unpacker request(message.content);
    Packer answer;
    if (message.kind == MessageKind::open) {
      answer(reader_.facts());
    } else if (message.kind == MessageKind::info) {
      std::string grid;
      bool values = false;
      request(grid, values);
      answer(grid.empty() ? reader_.info(values) : std::vector{reader_.info(grid, values)});
    } else if (message.kind == MessageKind::content) {
      std::string grid;
      request(grid);
      answer(reader_.content(grid));
    } else if (message.kind == MessageKind::read) {
      ReadRequest read;
      request(read);
      answer(this->read(read, message.descriptor.get()));
    } else if (message.kind == MessageKind::leaves && last_.reader) {
      LeavesRequest leaves;
      request(leaves);
      answer(values_of(leaves));
    } else {
      throw std::runtime_error("an unknown request");
    }
    return answer.text();
  }

  /// Keeps the last field, so that the reader keeps its grid.
  FieldFacts read(const ReadRequest& request, int memory) {
    Field field = reader_.read(request.grid, request.options);
    FieldFacts facts;
    facts.leaves = field.leaves.size();
    facts.tiles = field.tiles.size();
    facts.stored = field.reader != nullptr;
    if (const auto* values = dynamic_cast<const ActiveValues*>(field.reader.get()))
      facts.active_tiles = values->active_tiles();
    facts.same_values = request.holds_last && shares_values(field, last_);
    if (!facts.same_values) write_shared(field, memory, facts);
    last_ = std::move(field);
    if (facts.stored) last_.leaves = {};  // its reader knows their places
    facts.field = without_values(last_);
    return facts;
  }

  LeavesAnswer values_of(const LeavesRequest& request) const {
    LeavesAnswer answer;
    answer.values.resize(request.numbers.size() * kLeafVoxels *
                         static_cast<std::size_t>(last_.channels) * sizeof(float));
    auto* const values = reinterpret_cast<float*>(answer.values.data());
    if (request.survey)
      answer.survey = last_.reader->survey(request.numbers, values);
    else if (const auto* leaves = dynamic_cast<const ActiveValues*>(last_.reader.get());
             leaves && request.active)
      leaves->read_active(request.numbers, values);
    else
      last_.reader->read(request.numbers, values);
    return answer;
  }

  /// A notice would tell that values were changed.
  static bool shares_values(const Field& a, const Field& b) {
    return a.storage && a.storage == b.storage && a.notices.empty() && b.notices.empty() &&
           std::ranges::equal(a.tiles, b.tiles, [](const Tile& x, const Tile& y) {
             return x.origin == y.origin && x.width == y.width && x.value == y.value;
           });
  }

  static Field without_values(const Field& field) {
    Field facts = field;
    facts.leaves.clear();
    facts.tiles.clear();
    facts.storage.reset();
    facts.reader.reset();
    return facts;
  }

  void fail(ExitCode code, const std::string& message) {
    Packer content;
    content(Failure{static_cast<int>(code), message});
    reply(MessageKind::failure, content.text());
  }

  void reply(MessageKind kind, std::string_view content) {
    if (!send(connection_, kind, content)) _exit(0);
  }

  /// Not more than every few milliseconds, however fast the file is read.
  void report(double fraction) {
    constexpr std::chrono::milliseconds pause(20);
    const auto now = std::chrono::steady_clock::now();
    if (fraction < 1 && now - reported_ < pause) return;
    reported_ = now;
    Packer content;
    content(fraction);
    reply(MessageKind::progress, content.text());
  }

  int connection_;
  std::shared_ptr<FileBlocks> file_;
  InPlaceReader reader_{file_, [this](double fraction) { report(fraction); }};
  std::chrono::steady_clock::time_point reported_{};
  Field last_;
};

}  // namespace

void serve_reader(int connection) {
  try {
    std::unique_ptr<Service> service;
    MessageInput input;
    while (input.receive(connection)) {
      while (std::optional<Message> message = input.next()) {
        if (!service && message->kind == MessageKind::open) {
          const std::uint64_t memory = available_memory() / 5 * 4;
          service = std::make_unique<Service>(connection, message->content,
                                              std::move(message->descriptor));
          restrict_process(memory);
        }
        if (service) service->answer(*message);
      }
    }
  } catch (const std::exception&) {
    _exit(1);
  }
  _exit(0);
}

}  // namespace psivox::vdb
