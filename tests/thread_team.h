#pragma once

#include <algorithm>
#include <barrier>
#include <cstdlib>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "psivox/team.h"

namespace psivox::test {

/// What the members of a team of threads share.
struct Exchange {
  explicit Exchange(int count) : met(count), texts(std::size_t(count)) {}
  std::barrier<> met;
  std::vector<std::string> texts;
  std::vector<std::vector<std::span<const std::byte>>> sent{texts.size()};
  std::vector<double> reports = std::vector<double>(texts.size());
  std::mutex reporting;
};

/// A member that is a thread.
class ThreadMember final : public Team {
 public:
  ThreadMember(Exchange& shared, int rank)
      : Team({rank, int(shared.texts.size()), 0, 1, "here"}), shared_(shared) {}

  void report(double fraction) override {
    const std::lock_guard lock(shared_.reporting);
    shared_.reports[std::size_t(rank())] = fraction;
  }
  Reported reported() override {
    const std::lock_guard lock(shared_.reporting);
    return {*std::ranges::min_element(shared_.reports), 0.5};
  }
  void abort(int) override { std::abort(); }
  void finish() override {}

 protected:
  std::vector<std::string> all_gather(const std::string& bytes) override {
    return meet(shared_.texts, bytes);
  }
  void all_exchange(const std::vector<Bytes>& to, std::size_t, const Received& received) override {
    const auto all = meet(shared_.sent, to);
    const auto own = std::size_t(rank());
    for (std::size_t from = 0; from < all.size(); ++from)
      std::ranges::copy(all[from][own], received(from, all[from][own].size()));
    shared_.met.arrive_and_wait();  // until then the senders keep what they have sent
  }

 private:
  template <typename T>
  std::vector<T> meet(std::vector<T>& all, const T& own) {
    all[std::size_t(rank())] = own;
    shared_.met.arrive_and_wait();
    std::vector<T> result = all;
    shared_.met.arrive_and_wait();
    return result;
  }

  Exchange& shared_;
};

/// Does work in a team of so many. Returns the error that each has agreed to, or "".
inline std::vector<std::string> in_team(int count,
                                        const std::function<void(std::shared_ptr<Team>)>& work) {
  Exchange shared(count);
  std::vector<std::string> errors(std::size_t(count), "");
  std::vector<std::jthread> threads;
  for (int rank = 0; rank < count; ++rank)
    threads.emplace_back([&, rank] {
      try {
        work(std::make_shared<ThreadMember>(shared, rank));
      } catch (const AgreedError& error) {
        errors[std::size_t(rank)] = error.what();
      }
    });
  threads.clear();
  return errors;
}

}  // namespace psivox::test
