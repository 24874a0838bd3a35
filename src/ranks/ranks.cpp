#include "psivox/ranks.h"

#include <algorithm>
#include <exception>
#include <new>

namespace psivox {
namespace {

/// What all_gather sends: content, or an exit code, a machine's name, a line's end and a message.
constexpr char content = 'c', failure = 'f';

}  // namespace

std::vector<std::string> Ranks::checked(const std::vector<std::string>& messages) const {
  const auto failed = [](const std::string& message) { return message[0] == failure; };
  const auto first = std::ranges::find_if(messages, failed);
  if (first == messages.end()) {
    std::vector<std::string> contents;
    for (const std::string& message : messages) contents.push_back(message.substr(1));
    return contents;
  }
  const auto line_end = first->find('\n');
  std::string text = first->substr(line_end + 1);
  // what only some ranks met may be their machine's
  if (!std::ranges::all_of(messages, failed))
    text = "rank " + std::to_string(first - messages.begin()) + " of " + std::to_string(count()) +
           ", on " + first->substr(2, line_end - 2) + ": " + text;
  throw AgreedError(static_cast<ExitCode>((*first)[1]), text);
}

std::vector<std::string> Ranks::gather(const std::string& bytes) {
  return checked(all_gather(content + bytes));
}

std::vector<std::vector<glm::vec4>> Ranks::exchange(const std::vector<std::vector<glm::vec4>>& to) {
  gather("");  // where a rank that has failed is met
  return all_exchange(to);
}

void Ranks::check_same(const std::string& bytes, const std::string& differs) {
  const std::vector<std::string> all = gather(bytes);
  for (std::size_t rank = 1; rank < all.size(); ++rank)
    if (all[rank] != all[0])
      throw AgreedError(ExitCode::input,
                        "rank " + std::to_string(rank) + " " + differs + " than rank 0");
}

void Ranks::agree(const std::function<void()>& work) {
  std::string message(1, content);
  const auto fail = [&](ExitCode code, const std::string& what) {
    message = failure + std::string(1, static_cast<char>(code)) + place_.machine + "\n" + what;
  };
  try {
    work();
  } catch (const AgreedError&) {
    throw;
  } catch (const Error& error) {
    fail(error.code(), error.what());
  } catch (const std::bad_alloc&) {
    fail(ExitCode::memory, "out of memory; start more ranks, or set --memory-limit");
  } catch (const std::exception& error) {
    fail(ExitCode::failure, error.what());
  }
  checked(all_gather(message));
}

}  // namespace psivox
