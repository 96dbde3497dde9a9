#pragma once

#include <memory>
#include <mutex>
#include <string>

#include "core/base/result.h"
#include "io_node/devices/hd_library.h"

namespace hapton::hd {

// The one scheduler that libHD has in a process, shared by all its devices: the first to come starts it, the last to go stops it.
// RT: set-up only. Threads: any.
class Session {
 public:
  // The session of this library file, or of libHD by its names; the same for all who ask while one holds it.
  static Result<std::shared_ptr<Session>> join(const std::string& library_file = "");

  explicit Session(Library library) : hd_(std::move(library)) {}

  const Library& hd() const { return hd_; }

  // Opens the device of that name; of "", the first of those that are usual. Error: one line with the error's name and the library's words.
  Result<Handle> open(const std::string& name);
  // Calls `callback` each tick from now on.
  Result<Schedule> start(Callback callback, void* data);
  // Calls it no more, and closes the device. After this nothing of it is running.
  void close(Handle device, Schedule schedule);

 private:
  Error describe(const ErrorInfo& error, const std::string& what) const;

  Library hd_;
  std::mutex mutex_;
  int users_ = 0;
};

}  // namespace hapton::hd
