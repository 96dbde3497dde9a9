#include "watchdog/heartbeat_memory.h"

#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <new>

namespace hapton {
namespace {

void* map(int file) {
  void* const memory = ::mmap(nullptr, sizeof(HeartbeatPage), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  return memory == MAP_FAILED ? nullptr : memory;
}

}  // namespace

HeartbeatMemory::~HeartbeatMemory() {
  if (page_ != nullptr) ::munmap(page_, sizeof(HeartbeatPage));
  if (file_ >= 0) ::close(file_);
}

Result<void> HeartbeatMemory::make() {
  file_ = ::memfd_create("hapton-heartbeat", MFD_CLOEXEC);
  if (file_ < 0)
    return fail("no memory to share with the watchdog: {}; allow the process more open files (ulimit -n)", std::strerror(errno));
  void* const memory = ::ftruncate(file_, sizeof(HeartbeatPage)) == 0 ? map(file_) : nullptr;
  if (memory == nullptr) return fail("no memory to share with the watchdog: {}", std::strerror(errno));
  page_ = new (memory) HeartbeatPage;
  return {};
}

Result<void> HeartbeatMemory::open(int file) {
  file_ = file;
  struct stat found = {};
  const bool is_big_enough = ::fstat(file, &found) == 0 && found.st_size >= static_cast<off_t>(sizeof(HeartbeatPage));
  void* const memory = is_big_enough ? map(file) : nullptr;
  if (memory == nullptr) return fail("descriptor {} is not shared memory of io_node; this program is started by io_node", file);
  page_ = static_cast<HeartbeatPage*>(memory);
  if (page_->magic.load() != HeartbeatPage::kMagic)
    return fail("descriptor {} belongs to another version of io_node; reinstall both", file);
  return {};
}

}  // namespace hapton
