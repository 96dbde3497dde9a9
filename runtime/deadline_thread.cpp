#include "runtime/deadline_thread.h"

#include <sys/syscall.h>
#include <unistd.h>

namespace hapton {
namespace {

constexpr std::uint32_t kDeadlinePolicy = 6;  // SCHED_DEADLINE
constexpr std::uint64_t kResetOnFork = 1;     // SCHED_FLAG_RESET_ON_FORK

// The kernel's struct sched_attr, which the C library does not declare.
struct Attributes {
  std::uint32_t size = sizeof(Attributes);
  std::uint32_t policy = kDeadlinePolicy;
  std::uint64_t flags = kResetOnFork;
  std::int32_t nice = 0;
  std::uint32_t priority = 0;
  std::uint64_t runtime_ns = 0;
  std::uint64_t deadline_ns = 0;
  std::uint64_t period_ns = 0;
};

}  // namespace

bool enter_deadline(std::int64_t runtime_ns, std::int64_t period_ns) noexcept {
  Attributes attributes;
  attributes.runtime_ns = static_cast<std::uint64_t>(runtime_ns);
  attributes.deadline_ns = attributes.period_ns = static_cast<std::uint64_t>(period_ns);
  return ::syscall(SYS_sched_setattr, 0, &attributes, 0) == 0;
}

}  // namespace hapton
