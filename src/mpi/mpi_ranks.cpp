// Ranks of MPI. CMake compiles this file once for each MPI that it finds.
#define OMPI_SKIP_MPICXX 1  // the C++ bindings, which need a library of their own
#define MPICH_SKIP_MPICXX 1
#include <mpi.h>

#include <algorithm>
#include <chrono>
#include <climits>
#include <numeric>
#include <thread>

#include "psivox/ranks.h"

namespace psivox {
namespace {

constexpr int progress_tag = 1;

/// Begins of parts that lie one after another.
std::vector<int> begins(const std::vector<int>& sizes) {
  std::vector<int> result(sizes.size());
  std::exclusive_scan(sizes.begin(), sizes.end(), result.begin(), 0);
  return result;
}

int checked_size(std::size_t size) {
  if (size > INT_MAX) throw Error(ExitCode::memory, "a message of MPI would be over 2 GiB");
  return static_cast<int>(size);
}

RankPlace find_place() {
  RankPlace place;
  MPI_Comm_rank(MPI_COMM_WORLD, &place.rank);
  MPI_Comm_size(MPI_COMM_WORLD, &place.count);
  MPI_Comm machine = MPI_COMM_NULL;
  MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, place.rank, MPI_INFO_NULL, &machine);
  MPI_Comm_rank(machine, &place.local_rank);
  MPI_Comm_size(machine, &place.local_count);
  MPI_Comm_free(&machine);
  char name[MPI_MAX_PROCESSOR_NAME];
  int length = 0;
  MPI_Get_processor_name(name, &length);
  place.machine.assign(name, static_cast<std::size_t>(length));
  return place;
}

class MpiRanks final : public Ranks {
 public:
  MpiRanks() : Ranks(find_place()), reported_(static_cast<std::size_t>(count()), 0.0) {
    MPI_Type_contiguous(4, MPI_FLOAT, &pixel_);
    MPI_Type_commit(&pixel_);
  }

  std::vector<std::vector<float>> collect(const std::vector<float>& part) override {
    const int size = checked_size(part.size());
    std::vector<int> sizes(first() ? static_cast<std::size_t>(count()) : 0);
    MPI_Request request = MPI_REQUEST_NULL;
    MPI_Igather(&size, 1, MPI_INT, sizes.data(), 1, MPI_INT, 0, MPI_COMM_WORLD, &request);
    wait(request);
    const std::vector<int> at = begins(sizes);
    std::vector<float> all(
        std::accumulate(sizes.begin(), sizes.end(), std::size_t{0},
                        [](std::size_t sum, int n) { return sum + static_cast<std::size_t>(n); }));
    checked_size(all.size());
    MPI_Igatherv(part.data(), size, MPI_FLOAT, all.data(), sizes.data(), at.data(), MPI_FLOAT, 0,
                 MPI_COMM_WORLD, &request);
    wait(request);
    if (!first()) return {};
    return parts(all, at, sizes);
  }

  void report(double fraction) override {
    if (first())
      reported_[0] = fraction;
    else
      MPI_Send(&fraction, 1, MPI_DOUBLE, 0, progress_tag, MPI_COMM_WORLD);
  }

  Reported reported() override {
    for (int there = 1; there;) {
      MPI_Status status;
      MPI_Iprobe(MPI_ANY_SOURCE, progress_tag, MPI_COMM_WORLD, &there, &status);
      if (there)
        MPI_Recv(&reported_[static_cast<std::size_t>(status.MPI_SOURCE)], 1, MPI_DOUBLE,
                 status.MPI_SOURCE, progress_tag, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
    }
    Reported result{1, 0};
    for (const double fraction : reported_) {
      result.least = std::min(result.least, fraction);
      result.mean += fraction / static_cast<double>(reported_.size());
    }
    return result;
  }

  void abort(int code) override { MPI_Abort(MPI_COMM_WORLD, code); }
  void finish() override {
    MPI_Type_free(&pixel_);
    MPI_Finalize();
  }

 protected:
  std::vector<std::string> all_gather(const std::string& bytes) override {
    const int size = checked_size(bytes.size());
    std::vector<int> sizes(static_cast<std::size_t>(count()));
    MPI_Request request = MPI_REQUEST_NULL;
    MPI_Iallgather(&size, 1, MPI_INT, sizes.data(), 1, MPI_INT, MPI_COMM_WORLD, &request);
    wait(request);
    const std::vector<int> at = begins(sizes);
    std::string all(static_cast<std::size_t>(at.back() + sizes.back()), '\0');
    MPI_Iallgatherv(bytes.data(), size, MPI_CHAR, all.data(), sizes.data(), at.data(), MPI_CHAR,
                    MPI_COMM_WORLD, &request);
    wait(request);
    std::vector<std::string> result;
    for (std::size_t rank = 0; rank < sizes.size(); ++rank)
      result.push_back(
          all.substr(static_cast<std::size_t>(at[rank]), static_cast<std::size_t>(sizes[rank])));
    return result;
  }

  std::vector<std::vector<glm::vec4>> all_exchange(
      const std::vector<std::vector<glm::vec4>>& to) override {
    std::vector<int> sent;
    std::vector<glm::vec4> all;
    for (const auto& part : to) {
      sent.push_back(checked_size(part.size()));
      all.insert(all.end(), part.begin(), part.end());
    }
    checked_size(all.size());
    std::vector<int> received(sent.size());
    MPI_Request request = MPI_REQUEST_NULL;
    MPI_Ialltoall(sent.data(), 1, MPI_INT, received.data(), 1, MPI_INT, MPI_COMM_WORLD, &request);
    wait(request);
    const std::vector<int> from = begins(sent), at = begins(received);
    std::vector<glm::vec4> taken(static_cast<std::size_t>(at.back() + received.back()));
    MPI_Ialltoallv(all.data(), sent.data(), from.data(), pixel_, taken.data(), received.data(),
                   at.data(), pixel_, MPI_COMM_WORLD, &request);
    wait(request);
    return parts(taken, at, received);
  }

 private:
  /// For a message to all ranks, without taking the processor from those that still work: MPICH
  /// spins in calls that wait, and where ranks are more than cores each has to wait for another's
  /// turn of the processor.
  static void wait(MPI_Request& request) {
    std::chrono::microseconds pause{20};
    for (int done = 0; MPI_Test(&request, &done, MPI_STATUS_IGNORE), !done;) {
      std::this_thread::sleep_for(pause);
      pause = std::min(2 * pause, std::chrono::microseconds{1000});
    }
  }

  template <typename T>
  static std::vector<std::vector<T>> parts(const std::vector<T>& all, const std::vector<int>& at,
                                           const std::vector<int>& sizes) {
    std::vector<std::vector<T>> result;
    for (std::size_t rank = 0; rank < sizes.size(); ++rank)
      result.emplace_back(all.begin() + at[rank], all.begin() + at[rank] + sizes[rank]);
    return result;
  }

  MPI_Datatype pixel_ = MPI_DATATYPE_NULL;
  std::vector<double> reported_;
};

}  // namespace
}  // namespace psivox

extern "C" psivox::Ranks* psivox_open_ranks() {
  int level = 0;
  MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &level);
  return new psivox::MpiRanks();
}
