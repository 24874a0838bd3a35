// A team of MPI's processes. CMake compiles this file once for each MPI that it finds.
#define OMPI_SKIP_MPICXX 1  // the C++ bindings, which need a library of their own
#define MPICH_SKIP_MPICXX 1
#include <mpi.h>

#include <algorithm>
#include <chrono>
#include <climits>
#include <cstdlib>
#include <numeric>
#include <thread>

#include "psivox/team.h"

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

/// Items that lie one after another; fails if MPI cannot count them.
std::size_t total(const std::vector<int>& sizes) {
  std::size_t sum = 0;
  for (const int size : sizes) sum += static_cast<std::size_t>(size);
  checked_size(sum);
  return sum;
}

/// A type of so many bytes, for MPI counts items by int.
class Item {
 public:
  explicit Item(std::size_t bytes) {
    MPI_Type_contiguous(static_cast<int>(bytes), MPI_BYTE, &type_);
    MPI_Type_commit(&type_);
  }
  ~Item() { MPI_Type_free(&type_); }
  Item(const Item&) = delete;
  Item& operator=(const Item&) = delete;
  MPI_Datatype get() const { return type_; }

 private:
  MPI_Datatype type_ = MPI_DATATYPE_NULL;
};

Team::Place find_place() {
  Team::Place place;
  MPI_Comm_rank(MPI_COMM_WORLD, &place.rank);
  MPI_Comm_size(MPI_COMM_WORLD, &place.size);
  MPI_Comm machine = MPI_COMM_NULL;
  MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, place.rank, MPI_INFO_NULL, &machine);
  MPI_Comm_rank(machine, &place.local_rank);
  MPI_Comm_size(machine, &place.local_size);
  MPI_Comm_free(&machine);
  char name[MPI_MAX_PROCESSOR_NAME];
  int length = 0;
  MPI_Get_processor_name(name, &length);
  place.machine.assign(name, static_cast<std::size_t>(length));
  return place;
}

class MpiTeam final : public Team {
 public:
  MpiTeam() : Team(find_place()), reported_(static_cast<std::size_t>(size()), 0.0) {}

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

  void abort(int code) override {
    MPI_Abort(MPI_COMM_WORLD, code);
    std::_Exit(code);
  }
  void finish() override { MPI_Finalize(); }

 protected:
  std::vector<std::string> all_gather(const std::string& bytes) override {
    const int own = checked_size(bytes.size());
    std::vector<int> sizes(static_cast<std::size_t>(size()));
    MPI_Request request = MPI_REQUEST_NULL;
    MPI_Iallgather(&own, 1, MPI_INT, sizes.data(), 1, MPI_INT, MPI_COMM_WORLD, &request);
    wait(request);
    const std::vector<int> at = begins(sizes);
    std::string all(static_cast<std::size_t>(at.back() + sizes.back()), '\0');
    MPI_Iallgatherv(bytes.data(), own, MPI_CHAR, all.data(), sizes.data(), at.data(), MPI_CHAR,
                    MPI_COMM_WORLD, &request);
    wait(request);
    std::vector<std::string> result;
    for (std::size_t rank = 0; rank < sizes.size(); ++rank)
      result.push_back(
          all.substr(static_cast<std::size_t>(at[rank]), static_cast<std::size_t>(sizes[rank])));
    return result;
  }

  void all_exchange(const std::vector<Bytes>& to, std::size_t item,
                    const Received& received) override {
    const Item type(item);
    std::vector<int> sent;
    std::vector<std::byte> all;
    for (const Bytes& part : to) {
      sent.push_back(checked_size(part.size() / item));
      all.insert(all.end(), part.begin(), part.end());
    }
    std::vector<int> sizes(sent.size());
    MPI_Request request = MPI_REQUEST_NULL;
    MPI_Ialltoall(sent.data(), 1, MPI_INT, sizes.data(), 1, MPI_INT, MPI_COMM_WORLD, &request);
    wait(request);
    total(sent);
    std::vector<std::byte> taken(total(sizes) * item);
    const std::vector<int> from = begins(sent), at = begins(sizes);
    MPI_Ialltoallv(all.data(), sent.data(), from.data(), type.get(), taken.data(), sizes.data(),
                   at.data(), type.get(), MPI_COMM_WORLD, &request);
    wait(request);
    const std::byte* next = taken.data();
    for (std::size_t rank = 0; rank < sizes.size(); ++rank) {
      const std::size_t bytes = static_cast<std::size_t>(sizes[rank]) * item;
      std::copy_n(next, bytes, received(rank, bytes));
      next += bytes;
    }
  }

 private:
  /// Waits for a message to all ranks, but leaves the processor to ranks that still work: MPICH
  /// spins in calls that wait, and where ranks are more than cores each has to wait for another's
  /// turn of the processor.
  static void wait(MPI_Request& request) {
    std::chrono::microseconds pause{20};
    for (int done = 0; MPI_Test(&request, &done, MPI_STATUS_IGNORE), !done;) {
      std::this_thread::sleep_for(pause);
      pause = std::min(2 * pause, std::chrono::microseconds{1000});
    }
  }

  std::vector<double> reported_;
};

}  // namespace
}  // namespace psivox

extern "C" psivox::Team* psivox_open_team() {
  int level = 0;
  MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &level);
  return new psivox::MpiTeam();
}
