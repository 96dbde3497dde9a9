#include "link/random_id.h"

#include <sys/random.h>
#include <unistd.h>

#include <ctime>

namespace hapton {

std::uint64_t make_random_id() {
  std::uint64_t id = 0;
  // getrandom returns up to 256 bytes completely or not at all. Without them (a kernel before 3.17), the process number and the time still
  // distinguish two starts.
  if (getrandom(&id, sizeof id, 0) != static_cast<ssize_t>(sizeof id)) {
    timespec now = {};
    clock_gettime(CLOCK_REALTIME, &now);
    id = (static_cast<std::uint64_t>(getpid()) << 40) ^ (static_cast<std::uint64_t>(now.tv_sec) << 30) ^
         static_cast<std::uint64_t>(now.tv_nsec);
  }
  return id == 0 ? 1 : id;
}

}  // namespace hapton
