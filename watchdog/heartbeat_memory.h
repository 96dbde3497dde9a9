#pragma once

#include "core/base/result.h"
#include "watchdog/heartbeat_page.h"

namespace hapton {

// The number of the descriptor that the watchdog process inherits from io_node and that refers to its page.
constexpr int kHeartbeatDescriptor = 3;

// A HeartbeatPage in memory that is shared with a child process, which inherits its descriptor.
// RT: set-up only; the page itself is wait-free. Threads: one.
class HeartbeatMemory {
 public:
  HeartbeatMemory() = default;
  ~HeartbeatMemory();
  HeartbeatMemory(const HeartbeatMemory&) = delete;
  HeartbeatMemory& operator=(const HeartbeatMemory&) = delete;

  // Makes a new page. Error, one line: no memory or no free descriptor. Pre: neither make() nor open() was called before.
  Result<void> make();
  // Maps the page of another process. Owns its descriptor `file` from then on, also after an error. Error: it is not that of such a page.
  Result<void> open(int file);

  bool is_there() const noexcept { return page_ != nullptr; }
  // The page. Pre: is_there().
  HeartbeatPage& page() const noexcept { return *page_; }
  int file() const noexcept { return file_; }

 private:
  int file_ = -1;
  HeartbeatPage* page_ = nullptr;
};

}  // namespace hapton
