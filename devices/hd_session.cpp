#include "devices/hd_session.h"

#include <fmt/core.h>

#include <array>
#include <map>
#include <vector>

namespace hapton::hd {
namespace {

// The default names in OpenHaptics 3.3 and later, and in earlier releases; nullptr: the library's own default device.
constexpr std::array<const char*, 3> kUsualNames = {"Default Device", "Default PHANToM", nullptr};

std::string quoted(const char* name) { return name != nullptr ? fmt::format("'{}'", name) : "the library's default device"; }

}  // namespace

Result<std::shared_ptr<Session>> Session::join(const std::string& library_file) {
  static std::mutex mutex;
  static std::map<std::string, std::weak_ptr<Session>> sessions;
  const std::lock_guard lock(mutex);
  if (auto joined = sessions[library_file].lock()) return joined;
  auto library = load(library_file);
  if (!library) return tl::unexpected(library.error());
  auto session = std::make_shared<Session>(std::move(*library));
  sessions[library_file] = session;
  return session;
}

Error Session::describe(const ErrorInfo& error, const std::string& what) const {
  const char* message = hd_.get_error_string(error.code);
  const std::string_view remedy = remedy_for_error(error.code);
  return {fmt::format("OpenHaptics {}: {}, internal code {}{}{}{}{}", what, name_of_error(error.code), error.internal_code,
                      message != nullptr && *message != '\0' ? ", \"" : "", message != nullptr ? message : "",
                      message != nullptr && *message != '\0' ? "\"" : "", remedy.empty() ? "" : fmt::format("; {}", remedy))};
}

Result<Handle> Session::open(const std::string& name) {
  std::vector<const char*> names(kUsualNames.begin(), kUsualNames.end());
  if (!name.empty()) names = {name.c_str()};
  ErrorInfo first_error = {};
  for (const char* candidate : names) {
    forget_errors(hd_);  // earlier errors: with one left, a device that opens would count as failed, and stay open
    const Handle device = hd_.init_device(candidate);
    const ErrorInfo error = hd_.get_error();
    if (error.code == kSuccess && device != kInvalidHandle) return device;
    if (first_error.code == kSuccess) first_error = error;
  }
  std::string tried_names;
  for (const char* candidate : names) tried_names += (tried_names.empty() ? "" : ", ") + quoted(candidate);
  if (first_error.code == kSuccess)
    return fail("OpenHaptics has no device {}; give the name from its set-up (Touch_Setup) with --device-id", tried_names);
  return tl::unexpected(describe(first_error, "cannot open " + tried_names));
}

Result<Session::Attached> Session::attach_stopped(const std::string& name, const std::function<Result<void>(Handle)>& set_up,
                                                  Callback callback, void* data) {
  const auto device = open(name);
  if (!device) return tl::unexpected(device.error());
  hd_.make_current_device(*device);
  if (const auto done = set_up(*device); !done) {
    hd_.disable_device(*device);
    return tl::unexpected(done.error());
  }
  forget_errors(hd_);
  return Attached{*device, hd_.schedule_asynchronous(callback, data, kHighestPriority)};
}

Result<Session::Attached> Session::attach(const std::string& name, const std::function<Result<void>(Handle)>& set_up, Callback callback,
                                          void* data) {
  const std::lock_guard lock(mutex_);
  if (attached_count_ > 0) hd_.stop_scheduler();
  auto attached = attach_stopped(name, set_up, callback, data);
  if (!attached) forget_errors(hd_);  // another device in use would take these errors for its own
  if (attached_count_ > 0 || attached) hd_.start_scheduler();
  if (!attached) return attached;
  // If other devices are in use, an error may be theirs, so it is not checked here.
  if (const ErrorInfo error = attached_count_ == 0 ? hd_.get_error() : ErrorInfo{}; is_device_error(error.code)) {
    hd_.stop_scheduler();
    hd_.unschedule(attached->schedule);
    hd_.disable_device(attached->device);
    return tl::unexpected(describe(error, "cannot start its scheduler"));
  }
  ++attached_count_;
  return attached;
}

void Session::detach(const Attached& attached) {
  const std::lock_guard lock(mutex_);
  hd_.stop_scheduler();
  hd_.unschedule(attached.schedule);
  hd_.disable_device(attached.device);
  forget_errors(hd_);
  if (--attached_count_ > 0) hd_.start_scheduler();
}

bool Session::has_users() const {
  const std::lock_guard lock(mutex_);
  return attached_count_ > 0;
}

}  // namespace hapton::hd
