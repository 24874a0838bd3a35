#pragma once

#include <functional>
#include <glm/vec4.hpp>
#include <memory>
#include <string>
#include <vector>

#include "psivox/error.h"

// Processes that draw one picture together, started by MPI's mpirun or by Slurm's srun.

namespace psivox {

/// One of several processes.
struct RankPlace {
  int rank = 0, count = 1;
  int local_rank = 0, local_count = 1;  ///< among those on the same machine
  std::string machine;

  /// Its own of so many things of the machine, which its processes take in turn.
  std::size_t in_turn(std::size_t things) const { return std::size_t(local_rank) % things; }
};

/// An error that all ranks know of and throw. One of them should report it.
class AgreedError : public Error {
 public:
  using Error::Error;
};

/// All ranks, as one of them sees them. All must make the same calls in the same order, each from
/// one thread.
class Ranks {
 public:
  explicit Ranks(RankPlace place) : place_(std::move(place)) {}
  virtual ~Ranks() = default;
  Ranks(const Ranks&) = delete;
  Ranks& operator=(const Ranks&) = delete;

  const RankPlace& place() const { return place_; }
  int rank() const { return place_.rank; }
  int count() const { return place_.count; }
  bool first() const { return place_.rank == 0; }

  /// What each rank gives, by rank. Throws AgreedError if a rank's agree() has failed instead.
  std::vector<std::string> gather(const std::string& bytes);

  /// Does work, which may gather. If it throws in some ranks, AgreedError is thrown in all, with
  /// the message of the first.
  void agree(const std::function<void()>& work);

  /// Throws AgreedError in all, if one gives other bytes than the first: "rank 2 `differs` than
  /// rank 0".
  void check_same(const std::string& bytes, const std::string& differs);

  /// Sends `to[r]` to each rank r. Returns what each has sent to this one. Throws as gather().
  std::vector<std::vector<glm::vec4>> exchange(const std::vector<std::vector<glm::vec4>>& to);
  /// Returns what each rank gives, by rank, in the first; in others nothing.
  virtual std::vector<std::vector<float>> collect(const std::vector<float>& part) = 0;

  /// Tells the first rank how much of the work is done here, 0 to 1. The last must be 1.
  virtual void report(double fraction) = 0;
  /// In the first rank: the least of what all have reported, and their mean.
  struct Reported {
    double least = 0, mean = 0;
  };
  virtual Reported reported() = 0;

  /// Ends all ranks at once.
  virtual void abort(int code) = 0;
  /// To be called by all before they end, after which nothing else may be.
  virtual void finish() = 0;

 protected:
  /// What each gives, by rank.
  virtual std::vector<std::string> all_gather(const std::string& bytes) = 0;
  /// exchange(), where all exchange.
  virtual std::vector<std::vector<glm::vec4>> all_exchange(
      const std::vector<std::vector<glm::vec4>>& to) = 0;

 private:
  std::vector<std::string> checked(const std::vector<std::string>& messages) const;

  RankPlace place_;
};

/// The ranks that this process was started with; null if it is alone, or if PSIVOX_MPI is `none`.
/// Throws Error(failure) if there is no module for the MPI that started it, and if ranks have
/// different versions of psivox. To be called once.
std::shared_ptr<Ranks> open_ranks();

}  // namespace psivox
