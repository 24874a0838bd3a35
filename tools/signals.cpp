#include "signals.h"

#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <thread>

#include "psivox/error.h"
#include "psivox/text_file.h"

namespace psivox {

void report_failed_writes() { std::signal(SIGXFSZ, SIG_IGN); }

void end_cleanly_on_signals() {
  static sigset_t ends;
  sigemptyset(&ends);
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) {
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

void end_after(int seconds, const char* message) {
  std::thread([=] {
    std::this_thread::sleep_for(std::chrono::seconds(seconds));
    remove_hidden_files();
    std::fprintf(stderr, "psivox: %s\n", message);
    _exit(static_cast<int>(ExitCode::failure));
  }).detach();
}

}  // namespace psivox
