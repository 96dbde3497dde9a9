#pragma once

#include "core/base/result.h"
#include "watchdog/heartbeat_page.h"

namespace hapton {

// The descriptor by which the watchdog process gets its page.
constexpr int kHeartbeatFile = 3;

// A HeartbeatPage in memory that can be handed to a child process by its descriptor.
// RT: set-up only; the page itself is wait-free. Threads: one.
class HeartbeatMemory {
 public:
  HeartbeatMemory() = default;
  ~HeartbeatMemory();
  HeartbeatMemory(const HeartbeatMemory&) = delete;
  HeartbeatMemory& operator=(const HeartbeatMemory&) = delete;

  // A new page. Error: no memory or descriptor, one line.
  Result<void> make();
  // Somebody else's, by its descriptor, which this then owns. Error: it is no such page.
  Result<void> open(int file);

  bool is_there() const noexcept { return page_ != nullptr; }
  // Pre: is_there().
  HeartbeatPage& page() const noexcept { return *page_; }
  int file() const noexcept { return file_; }

 private:
  int file_ = -1;
  HeartbeatPage* page_ = nullptr;
};

}  // namespace hapton
