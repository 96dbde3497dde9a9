#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "devices/hd_library.h"

namespace hapton::hd {

// The one scheduler that libHD has in a process, shared by all its devices: the first device starts it, the last one stops it. The library
// also has one current device, which opening and closing change. Meanwhile the scheduler is therefore stopped; otherwise a frame of one
// device might end with the force of another. RT: set-up only. Threads: any.
class Session {
 public:
  // The session of this library file (empty: libHD by its usual names). All callers share one session as long as any of them holds it.
  static Result<std::shared_ptr<Session>> join(const std::string& library_file = "");

  explicit Session(Library library) : hd_(std::move(library)) {}

  const Library& hd() const { return hd_; }

  struct Attached {
    Handle device = kInvalidHandle;
    Schedule schedule = 0;
  };

  // Opens the device of that name ("": the first of the usual names that can be opened), calls set_up while it is the current device, and
  // from then on lets the scheduler call `callback` each tick. Error: one line, from the library or from set_up.
  Result<Attached> attach(const std::string& name, const std::function<Result<void>(Handle)>& set_up, Callback callback, void* data);
  // Ends the calls of the device's callback and closes the device. After this its callback is not running.
  void detach(const Attached& attached);

  // Whether attaching one more device would interrupt others.
  bool has_users() const;

 private:
  Result<Handle> open(const std::string& name);
  Result<Attached> attach_stopped(const std::string& name, const std::function<Result<void>(Handle)>& set_up, Callback callback,
                                  void* data);
  Error describe(const ErrorInfo& error, const std::string& what) const;

  Library hd_;
  mutable std::mutex mutex_;
  int attached_count_ = 0;
};

}  // namespace hapton::hd
