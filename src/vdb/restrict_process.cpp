#include "restrict_process.h"

#include <fcntl.h>
#include <sched.h>
#include <seccomp.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <memory>
#include <thread>

namespace psivox::vdb {
namespace {

void limit(__rlimit_resource what, std::uint64_t most) {
  const rlimit values{most, most};
  setrlimit(what, &values);
}

/// Calls that need no look at their arguments: on open descriptors, memory, threads and time.
constexpr int allowed_calls[] = {SCMP_SYS(read),
                                 SCMP_SYS(readv),
                                 SCMP_SYS(pread64),
                                 SCMP_SYS(write),
                                 SCMP_SYS(lseek),
                                 SCMP_SYS(recvmsg),
                                 SCMP_SYS(sendmsg),
                                 SCMP_SYS(poll),
                                 SCMP_SYS(ppoll),
                                 SCMP_SYS(close),
                                 SCMP_SYS(dup),
                                 SCMP_SYS(fstat),
                                 SCMP_SYS(fadvise64),
                                 SCMP_SYS(pwritev),
                                 SCMP_SYS(ftruncate),
                                 SCMP_SYS(brk),
                                 SCMP_SYS(munmap),
                                 SCMP_SYS(mremap),
                                 SCMP_SYS(madvise),
                                 SCMP_SYS(futex),
                                 SCMP_SYS(set_robust_list),
                                 SCMP_SYS(rseq),
                                 SCMP_SYS(sched_yield),
                                 SCMP_SYS(sched_getaffinity),
                                 SCMP_SYS(gettid),
                                 SCMP_SYS(getpid),
                                 SCMP_SYS(membarrier),
                                 SCMP_SYS(rt_sigaction),
                                 SCMP_SYS(rt_sigprocmask),
                                 SCMP_SYS(rt_sigreturn),
                                 SCMP_SYS(sigaltstack),
                                 SCMP_SYS(restart_syscall),
                                 SCMP_SYS(exit),
                                 SCMP_SYS(exit_group),
                                 SCMP_SYS(clock_gettime),
                                 SCMP_SYS(clock_nanosleep),
                                 SCMP_SYS(nanosleep),
                                 SCMP_SYS(gettimeofday),
                                 SCMP_SYS(getrandom)};

/// Loads the filter. All other calls fail, as in a kernel that lacks them: then libraries do
/// without. An error is ignored, since limits of resources still hold.
void restrict_calls() {
  const std::unique_ptr<void, decltype(&seccomp_release)> filter(
      seccomp_init(SCMP_ACT_ERRNO(ENOSYS)), seccomp_release);
  if (!filter) return;
  const auto allow = [&](int call, auto... arguments) {
    seccomp_rule_add(filter.get(), SCMP_ACT_ALLOW, call, sizeof...(arguments), arguments...);
  };
  for (const int call : allowed_calls) allow(call);
  // threads, but no processes
  allow(SCMP_SYS(clone), SCMP_A0(SCMP_CMP_MASKED_EQ, CLONE_THREAD, CLONE_THREAD));
  // an abort sends a signal to the process itself
  allow(SCMP_SYS(tgkill), SCMP_A0(SCMP_CMP_EQ, static_cast<scmp_datum_t>(getpid())));
  // no new code
  allow(SCMP_SYS(mmap), SCMP_A2(SCMP_CMP_MASKED_EQ, PROT_EXEC, 0));
  allow(SCMP_SYS(mprotect), SCMP_A2(SCMP_CMP_MASKED_EQ, PROT_EXEC, 0));
  // limits can be asked for
  allow(SCMP_SYS(prlimit64), SCMP_A2(SCMP_CMP_EQ, 0));
  seccomp_load(filter.get());
}

}  // namespace

bool has_seccomp() { return !sanitised && seccomp_api_get() > 0; }

void restrict_process(std::uint64_t memory) {
  limit(RLIMIT_CORE, 0);
  if (memory == 0) memory = std::uint64_t{1} << 60;
  limit(RLIMIT_FSIZE, memory);
  if (sanitised) return;
  // stacks, and what the allocator reserves for each thread
  constexpr std::uint64_t stack = 16 << 20, reserved = 128 << 20;
  const std::uint64_t threads = std::thread::hardware_concurrency() + 1;
  limit(RLIMIT_DATA, memory + threads * stack);
  limit(RLIMIT_AS, 2 * memory + threads * (stack + reserved) + (std::uint64_t{4} << 30));
  restrict_calls();
}

}  // namespace psivox::vdb
