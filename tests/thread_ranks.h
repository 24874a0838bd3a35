#pragma once

#include <algorithm>
#include <barrier>
#include <cstdlib>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "psivox/ranks.h"

namespace psivox::test {

/// What the ranks of one process share.
struct Exchange {
  explicit Exchange(int count) : met(count), texts(std::size_t(count)) {}
  std::barrier<> met;
  std::vector<std::string> texts;
  std::vector<std::vector<float>> floats{texts.size()};
  std::vector<std::vector<std::vector<glm::vec4>>> pixels{texts.size()};
  std::vector<double> reports = std::vector<double>(texts.size());
  std::mutex reporting;
};

/// A rank that is a thread.
class ThreadRank final : public Ranks {
 public:
  ThreadRank(Exchange& shared, int rank)
      : Ranks({rank, int(shared.texts.size()), 0, 1, "here"}), shared_(shared) {}

  std::vector<std::vector<float>> collect(const std::vector<float>& part) override {
    const auto all = meet(shared_.floats, part);
    return first() ? all : std::vector<std::vector<float>>{};
  }
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
  std::vector<std::vector<glm::vec4>> all_exchange(
      const std::vector<std::vector<glm::vec4>>& to) override {
    const auto all = meet(shared_.pixels, to);
    std::vector<std::vector<glm::vec4>> received;
    for (const auto& from : all) received.push_back(from[std::size_t(rank())]);
    return received;
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

/// Does work in so many ranks. Returns the error that each has agreed to, or "".
inline std::vector<std::string> on_ranks(int count,
                                         const std::function<void(std::shared_ptr<Ranks>)>& work) {
  Exchange shared(count);
  std::vector<std::string> errors(std::size_t(count), "");
  std::vector<std::jthread> threads;
  for (int rank = 0; rank < count; ++rank)
    threads.emplace_back([&, rank] {
      try {
        work(std::make_shared<ThreadRank>(shared, rank));
      } catch (const AgreedError& error) {
        errors[std::size_t(rank)] = error.what();
      }
    });
  threads.clear();
  return errors;
}

}  // namespace psivox::test
