// psivox COMMAND ...: the program. Each command has its own file, cmd_NAME.cpp.

#include <fcntl.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <initializer_list>
#include <iostream>
#include <new>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "base/input_file.h"
#include "base/memory.h"
#include "base/terminal.h"
#include "base/text.h"
#include "base/text_file.h"
#include "command_line.h"
#include "psivox/draw.h"
#include "psivox/image.h"
#include "psivox/vdb.h"

namespace psivox {

void end_after(int seconds, const char* message) {
  std::thread([=] {
    std::this_thread::sleep_for(std::chrono::seconds(seconds));
    remove_hidden_files();
    print_notice(message);
    _exit(int(ExitCode::failure));
  }).detach();
}

namespace {

/// From now on this process keeps what it frees, but for large blocks, for its next allocations.
void keep_freed_memory() {
#ifdef __GLIBC__
  constexpr int kept = 1 << 28, ahead = 1 << 26, large = 1 << 25;  // bytes
  mallopt(M_TRIM_THRESHOLD, kept);                                 // the end of the heap that stays
  mallopt(M_MMAP_THRESHOLD, large);
  mallopt(M_TOP_PAD, ahead);  // the heap grows by this at a time
#endif
}

/// Puts a folder in place of standard streams that are closed: no file that is opened later takes
/// their numbers, and reading and writing them fails.
void hold_closed_streams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (fcntl(stream, F_GETFD) < 0) open("/", O_PATH);  // gets the least number that is free
}

/// Throws Error(memory) where threads have too little for their stacks, or the process for its
/// data: a driver of OpenGL would crash.
void check_limits() {
  const auto check = [](auto resource, rlim_t least, const char* of, const char* option) {
    rlimit now{};
    if (getrlimit(resource, &now) == 0 && now.rlim_cur < least)
      throw Error(ExitCode::memory,
                  formatted("the limit of the %s is %d KiB; ulimit %s %d is the "
                            "least that psivox runs with",
                            of, int(now.rlim_cur >> 10), option, int(least >> 10)));
  };
  check(RLIMIT_STACK, 512 << 10, "stack", "-s");
  check(RLIMIT_DATA, 200 << 20, "data", "-d");
}

/// From now on a write beyond the limit of a file's size fails, and does not end the process.
void report_failed_writes() { std::signal(SIGXFSZ, SIG_IGN); }

/// From now on these signals end the process at once with 128 plus their number, and without
/// unfinished files: outputs that were begun are removed, or complete. To be called before other
/// threads start.
void end_cleanly_on(std::initializer_list<int> signals) {
  static sigset_t ends;
  sigemptyset(&ends);
  for (const int number : signals) {
    struct sigaction action {};
    sigaction(number, nullptr, &action);
    if (action.sa_handler != SIG_IGN) sigaddset(&ends, number);  // as of nohup
  }
  pthread_sigmask(SIG_BLOCK, &ends, nullptr);
  // a thread of its own may take locks, which a handler may not
  std::thread([] {
    int number = 0;
    while (sigwait(&ends, &number) != 0) continue;
    remove_hidden_files();
    if (isatty(STDERR_FILENO) == 1) std::fputs("\r\033[K", stderr);
    _exit(128 + number);
  }).detach();
}

struct Command {
  const char* name;
  void (*run)(Arguments);
  const char* summary;
  const char* elsewhere;  ///< what other programs call it
};

constexpr Command commands[] = {
    {"render", render_command, "render a volume to a picture file, without a window",
     "convert draw"},
    {"view", view_command, "show a volume in a window", "open show"},
    {"info", info_command, "list the grids of a volume", "list ls print"},
    {"compare", compare_command, "print the difference of two pictures", "diff idiff"},
    {"study", study_command, "measure the error and time of many methods", "bench benchmark"},
    {"verify", verify_command, "check this machine's GL driver", "check test"},
    {"examples", examples_command, "draw the volume that comes with psivox in five looks", "demo"},
};

void print_help() {
  std::cout << "psivox " PSIVOX_VERSION
               ": volume renderer for OpenVDB\n\n"
               "Usage: psivox COMMAND [OPTIONS], or psivox FILE.vdb to see it in a window\n\n"
               "Commands:\n";
  for (const Command& command : commands) {
    const std::string name = command.name;
    std::cout << "  " << name << std::string(12 - name.size(), ' ') << command.summary << '\n';
  }
  std::cout << "  help        print the help of a command: psivox help render\n"
               "  --version   print the versions of psivox, its libraries and the GL renderer\n"
               "  --help      print this; --help=man, =bash, =zsh or =fish a manual page or a\n"
               "              shell's completion\n\n"
               "Examples:\n"
               "  psivox render smoke.vdb -o smoke.png\n"
               "  psivox view smoke.vdb\n"
               "  psivox render --help\n";
}

/// `form`: man, or a shell.
void print_help_form(const std::string& form) {
  std::vector<std::pair<std::string, std::string>> all;
  for (const Command& command : commands) all.emplace_back(command.name, command.summary);
  std::cout << (form == "man" ? manual_of_program(all) : completion_script(form));
}

/// Prints what may stand in the place of the last word of a command line (completions()).
void print_completions(Arguments words) {
  for (const Command& command : commands) {
    if (words.size() == 1) std::cout << command.name << '\t' << command.summary << '\n';
    if (words.size() < 2 || words.front() != command.name) continue;
    std::vector<std::string> arguments(words.begin(), words.end());
    arguments.front() = "--complete";
    command.run(arguments);
  }
  if (words.size() == 1) std::cout << "--help\n--version\n";
}

/// What `get` returns, or why there is none.
std::string or_none(std::string (*get)()) {
  try {
    return get();
  } catch (const Error& error) {
    return std::string("none (") + error.what() + ")";
  }
}

void print_version() {
  std::cout << "psivox " PSIVOX_VERSION "\nOpenVDB " << openvdb_version() << "\nOpenImageIO "
            << or_none(openimageio_version) << "\nGL "
            << or_none([] { return description(*open_gpu()); }) << "\nReading is guarded by "
            << reading_guard() << '\n';
}

/// Whether this psivox can open a window here.
bool has_window() {
#ifdef PSIVOX_VIEWER
  return std::getenv("DISPLAY") || std::getenv("WAYLAND_DISPLAY");
#else
  return false;
#endif
}

/// Runs a command. `who` is set to the name that starts a usage error.
void run(const std::vector<std::string>& arguments, std::string& who) {
  if (arguments.empty()) throw Error(ExitCode::usage, "no command given; psivox --help lists them");
  const std::string& name = arguments.front();
  if (name == "help" && arguments.size() > 1) return run({arguments[1], "--help"}, who);
  if (std::ranges::count(std::vector{"--help", "--help-all", "--help=all", "-h", "help"}, name))
    return print_help();
  if (name.starts_with("--help=")) return print_help_form(name.substr(7));
  if (name == "--complete") return print_completions(Arguments(arguments).subspan(1));
  if (name == "--version") return print_version();
  std::vector<std::string> known = {"--help", "--version", "help"};
  for (const Command& command : commands) {
    known.emplace_back(command.name);
    if (name != command.name) continue;
    who += " " + name;
    // a study ends itself on SIGINT, and the system ends a window
    if (name == "study")
      end_cleanly_on({SIGTERM, SIGHUP});
    else if (name != "view")
      end_cleanly_on({SIGINT, SIGTERM, SIGHUP});
    allow_typed_names(arguments);
    std::optional<InputProtection> kept;
    if (name != "view") kept.emplace();  // a window saves what it has opened
    return command.run(Arguments(arguments).subspan(1));
  }
  std::error_code unknown;
  if (name.ends_with(".vdb") || name.ends_with(".nvdb") ||
      std::filesystem::is_regular_file(name, unknown) ||
      std::filesystem::is_directory(name, unknown)) {
    std::vector<std::string> view = arguments;
    view.insert(view.begin(), "view");
    if (has_window()) return run(view, who);
    throw Error(ExitCode::usage, "there is no window for " + in_quotes(name) +
                                     " here; psivox render " + shell_word(name) +
                                     " -o FILE.png draws it");
  }
  for (const Command& command : commands)
    if (std::ranges::count(split(command.elsewhere, ' '), name))
      throw Error(ExitCode::usage, "unknown command " + in_quotes(name) + "; psivox " +
                                       command.name + " does that here");
  throw Error(ExitCode::usage, std::string("unknown ") + (name[0] == '-' ? "option " : "command ") +
                                   in_quotes(name) + suggestion(name, known));
}

int fail(const std::string& who, const char* message, ExitCode code) {
  std::cout.flush();
  print(stderr, who + ": " + printable(message) + "\n");
  return int(code);
}

}  // namespace
}  // namespace psivox

int main(int argc, char** argv) {
  using namespace psivox;
  std::string who = "psivox";
  hold_closed_streams();
  report_failed_writes();
  keep_freed_memory();
  print_standard_output_safely();
  try {
    check_limits();
    start_guarded_reading();
    run({argv + (argc > 0 ? 1 : 0), argv + argc}, who);
    if (!std::cout.flush()) throw Error(ExitCode::output, "cannot write to the standard output");
    return 0;
  } catch (const Error& error) {
    return fail(error.code() == ExitCode::usage ? who : "psivox", error.what(), error.code());
  } catch (const std::bad_alloc&) {
    return fail("psivox",
                "out of memory; try a smaller --resolution, or --lod 1 for a large volume",
                ExitCode::memory);
  } catch (const std::exception& error) {
    if (lacks_threads(error))
      return fail("psivox", "the system gives no more threads or memory for them; raise the limits",
                  ExitCode::memory);
    return fail("psivox", error.what(), ExitCode::failure);
  }
}
