#pragma once

#include <cstddef>
#include <cstring>
#include <functional>
#include <memory>
#include <ranges>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "psivox/error.h"

// Processes that draw one picture together, started by MPI's mpirun or by Slurm's srun.

namespace psivox {

/// What a message can consist of.
template <typename T>
concept Plain = std::is_trivially_copyable_v<T> && !std::is_pointer_v<T> && !std::is_array_v<T>;

/// Many of them, one after another.
template <typename T>
concept PlainRange = std::ranges::contiguous_range<T> && std::ranges::sized_range<T> &&
    Plain<std::ranges::range_value_t<T>> && !std::is_convertible_v<T, std::string_view>;

/// An error that all members of a team know of and throw. One of them should report it.
class AgreedError : public Error {
 public:
  using Error::Error;
};

/// The processes that draw one picture, as one of them sees them: a process that is alone is a team
/// of one. All members must make the same calls in the same order, each from one thread; a team of
/// one may be used by several threads at a time.
///
/// Functions that send something throw AgreedError if agree() has failed in another member.
class Team {
 public:
  /// Where a member is among the others.
  struct Place {
    int rank = 0, size = 1;
    int local_rank = 0, local_size = 1;  ///< among the members on the same machine
    std::string machine;

    /// Which of a machine's `things`, such as GPUs, this member uses: its processes take them in
    /// turn.
    std::size_t in_turn(std::size_t things) const { return std::size_t(local_rank) % things; }
  };

  explicit Team(Place place) : place_(std::move(place)) {}
  virtual ~Team() = default;
  Team(const Team&) = delete;
  Team& operator=(const Team&) = delete;

  const Place& place() const { return place_; }
  int rank() const { return place_.rank; }
  int size() const { return place_.size; }
  bool first() const { return place_.rank == 0; }

  /// What each member gives, by rank.
  std::vector<std::string> gather(std::string_view bytes);
  template <Plain T>
  std::vector<T> gather(const T& value) requires(!PlainRange<T>);
  /// What each member gives, which may be more or less than others give.
  template <PlainRange Values>
  std::vector<std::vector<std::ranges::range_value_t<Values>>> gather(const Values& values);

  /// The sum of what all give, added in the order of ranks, so that all get the same bits.
  template <typename T>
  T sum(T number) requires std::is_arithmetic_v<T>;
  /// Sums element by element. All members must give equally many numbers.
  template <typename T>
  void sum(std::span<T> numbers) requires std::is_arithmetic_v<T>;

  /// Sends `to[r]` to each rank r. Returns what each has sent to this one.
  template <Plain T>
  std::vector<std::vector<T>> exchange(const std::vector<std::vector<T>>& to);

  /// In the first: what each gives, by rank. In others, only empty ones. It does not notice that
  /// another has failed: for members that have just met by another function.
  template <PlainRange Values>
  std::vector<std::vector<std::ranges::range_value_t<Values>>> collect(const Values& values);

  /// Does work, which may gather. If it throws in some members, AgreedError is thrown in all, with
  /// the message of the first.
  void agree(const std::function<void()>& work);

  /// Throws AgreedError in all, if one gives other bytes than the first: "rank 2 `differs` than
  /// rank 0".
  void check_same(std::string_view bytes, const std::string& differs);

  /// Tells the first how much of the work is done here, 0 to 1. The last must be 1.
  virtual void report(double fraction) = 0;
  /// In the first: the least of what all have reported, and their mean.
  struct Reported {
    double least = 0, mean = 0;
  };
  virtual Reported reported() = 0;

  /// Ends all members at once.
  [[noreturn]] virtual void abort(int code) = 0;
  /// To be called by all before they end, after which nothing else may be.
  virtual void finish() = 0;

 protected:
  using Bytes = std::span<const std::byte>;
  /// Where a message of so many bytes from a rank goes.
  using Received = std::function<std::byte*(std::size_t rank, std::size_t bytes)>;

  virtual std::vector<std::string> all_gather(const std::string& bytes) = 0;
  /// exchange(), where all exchange: items of so many bytes each.
  virtual void all_exchange(const std::vector<Bytes>& to, std::size_t item,
                            const Received& received) = 0;

 private:
  std::vector<std::string> checked(std::vector<std::string> messages) const;

  template <typename T>
  static Received into(std::vector<std::vector<T>>& all) {
    return [&all](std::size_t rank, std::size_t bytes) {
      all[rank].resize(bytes / sizeof(T));
      return reinterpret_cast<std::byte*>(all[rank].data());
    };
  }

  Place place_;
};

/// The team of a process that is alone. It fails and throws as if there were none.
const std::shared_ptr<Team>& alone();

/// The team that this process was started in; alone(), if it was started by itself or if PSIVOX_MPI
/// is `none`. Throws Error(failure) if there is no module for the MPI that started it, and if
/// members have different versions of psivox. To be called once.
std::shared_ptr<Team> open_team();

template <Plain T>
std::vector<T> Team::gather(const T& value) requires(!PlainRange<T>) {
  std::vector<T> all;
  for (const auto& one : gather(std::span(&value, 1))) all.push_back(one.front());
  return all;
}

template <PlainRange Values>
std::vector<std::vector<std::ranges::range_value_t<Values>>> Team::gather(const Values& values) {
  using T = std::ranges::range_value_t<Values>;
  const std::span<const T> own(values);
  std::vector<std::vector<T>> all;
  for (const std::string& bytes :
       gather(std::string_view(reinterpret_cast<const char*>(own.data()), own.size_bytes()))) {
    all.emplace_back(bytes.size() / sizeof(T));
    if (!bytes.empty()) std::memcpy(all.back().data(), bytes.data(), bytes.size());
  }
  return all;
}

template <typename T>
T Team::sum(T number) requires std::is_arithmetic_v<T> {
  sum(std::span(&number, 1));
  return number;
}

template <typename T>
void Team::sum(std::span<T> numbers) requires std::is_arithmetic_v<T> {
  if (size() == 1) return;
  constexpr std::size_t at_once = 1 << 16;  // so that many members take no more memory than few
  do {
    const std::span<T> some = numbers.first(std::min(at_once, numbers.size()));
    const auto all = gather(some);
    for (std::size_t i = 0; i < some.size(); ++i) {
      some[i] = all[0][i];
      for (std::size_t rank = 1; rank < all.size(); ++rank) some[i] += all[rank][i];
    }
    numbers = numbers.subspan(some.size());
  } while (!numbers.empty());
}

template <Plain T>
std::vector<std::vector<T>> Team::exchange(const std::vector<std::vector<T>>& to) {
  if (size() == 1) return to;
  gather("");  // where a member that has failed is met
  std::vector<std::vector<T>> from(to.size());
  std::vector<Bytes> sent;
  for (const std::vector<T>& items : to) sent.push_back(std::as_bytes(std::span(items)));
  all_exchange(sent, sizeof(T), into(from));
  return from;
}

template <PlainRange Values>
std::vector<std::vector<std::ranges::range_value_t<Values>>> Team::collect(const Values& values) {
  using T = std::ranges::range_value_t<Values>;
  std::vector<std::vector<T>> from(static_cast<std::size_t>(size()));
  std::vector<Bytes> sent(from.size());
  sent[0] = std::as_bytes(std::span<const T>(values));
  all_exchange(sent, sizeof(T), into(from));
  return from;
}

}  // namespace psivox
