#pragma once

#include <pybind11/pybind11.h>

#include <atomic>
#include <chrono>
#include <new>
#include <string>
#include <thread>
#include <utility>

#include "drawing.h"
#include "psivox/error.h"

namespace psivox::python {

namespace py = pybind11;

/// Carries a Python exception through the library, which must not take it for an error of its own.
struct Stop {
  py::error_already_set exception;
};

/// Counts the calls that work without the GIL. A thread that asked for the GIL while Python ends
/// would never get it, so Python waits for them.
class Working {
 public:
  Working() {
    check_open();
    ++calls_;
  }
  ~Working() { --calls_; }
  Working(const Working&) = delete;
  Working& operator=(const Working&) = delete;

  static void check_open() {
    if (ends_) throw Error(ExitCode::failure, "Python ends");
  }
  /// Stops a thread for ever whose call failed because Python ends in another one: it would print
  /// an error that nobody asked for. Python does the same with threads that ask for the GIL.
  static void stop_if_ended() {
    if (!ends_ || std::this_thread::get_id() == ender_) return;
    const py::gil_scoped_release others;
    for (;;) std::this_thread::sleep_for(std::chrono::hours(1));
  }
  /// Lets every call end, and refuses others. Call it with the GIL, with which calls begin.
  static void end() {
    ender_ = std::this_thread::get_id();
    ends_ = true;
    const py::gil_scoped_release others;
    while (calls_ > 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }

 private:
  static inline std::atomic<bool> ends_ = false;
  static inline std::thread::id ender_;  // of ends_
  static inline std::atomic<int> calls_ = 0;
};

/// Lets Python handle signals, and so Ctrl-C, at most every 50 ms. Call it without the GIL.
class SignalCheck {
 public:
  void operator()() {
    Working::check_open();
    const auto now = std::chrono::steady_clock::now();
    if (now - last_ < std::chrono::milliseconds(50)) return;
    last_ = now;
    const py::gil_scoped_acquire python;
    if (PyErr_CheckSignals() != 0) throw Stop{py::error_already_set()};
  }

 private:
  std::chrono::steady_clock::time_point last_{};
};

/// Runs work of the library without the GIL. What it throws becomes an Error or Python's exception.
template <typename Work>
auto run(Work&& work) {
  try {
    const Working working;
    const py::gil_scoped_release others;
    check_process();
    return work();
  } catch (Stop& stop) {
    throw py::error_already_set(std::move(stop.exception));
  } catch (const Error&) {
    Working::stop_if_ended();
    throw;
  } catch (const std::bad_alloc&) {
    throw Error(ExitCode::memory, "out of memory; try a smaller --resolution, or --lod 1");
  } catch (const py::builtin_exception&) {
    throw;
  } catch (const std::exception& error) {
    throw Error(ExitCode::failure, error.what());
  }
}

/// Calls `report`, unless it is None, and lets Ctrl-C end the work.
Progress reporting(const py::object& report);

/// A message of the command line with the names that keywords have: `--early-termination` becomes
/// `early_termination`.
std::string with_keywords(const std::string& message);

/// Adds the parts of the module that read and make grids.
void define_grids(py::module_& m);

}  // namespace psivox::python
