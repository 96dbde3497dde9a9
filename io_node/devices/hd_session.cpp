#include "io_node/devices/hd_session.h"

#include <fmt/core.h>

#include <array>
#include <map>
#include <vector>

namespace hapton::hd {
namespace {

// Of OpenHaptics 3.3 and later, of those before, and whatever the library takes for its default.
constexpr std::array<const char*, 3> kUsualNames = {"Default Device", "Default PHANToM", nullptr};

std::string quoted(const char* name) { return name != nullptr ? fmt::format("'{}'", name) : "the library's default device"; }

}  // namespace

Result<std::shared_ptr<Session>> Session::join(const std::string& library_file) {
  static std::mutex mutex;
  static std::map<std::string, std::weak_ptr<Session>> sessions;
  const std::lock_guard lock(mutex);
  if (auto there = sessions[library_file].lock()) return there;
  auto library = load(library_file);
  if (!library) return tl::unexpected(library.error());
  auto session = std::make_shared<Session>(std::move(*library));
  sessions[library_file] = session;
  return session;
}

Error Session::describe(const ErrorInfo& error, const std::string& what) const {
  const char* said = hd_.get_error_string(error.code);
  const std::string_view remedy = remedy_for_error(error.code);
  return {fmt::format("OpenHaptics {}: {}, internal code {}{}{}{}{}", what, name_of_error(error.code), error.internal_code,
                      said != nullptr && *said != '\0' ? ", \"" : "", said != nullptr ? said : "",
                      said != nullptr && *said != '\0' ? "\"" : "", remedy.empty() ? "" : fmt::format("; {}", remedy))};
}

Result<Handle> Session::open(const std::string& name) {
  const std::lock_guard lock(mutex_);
  std::vector<const char*> names(kUsualNames.begin(), kUsualNames.end());
  if (!name.empty()) names = {name.c_str()};
  ErrorInfo first = {};
  for (const char* candidate : names) {
    const Handle device = hd_.init_device(candidate);
    const ErrorInfo error = hd_.get_error();
    if (error.code == kSuccess && device != kInvalidHandle) return device;
    if (first.code == kSuccess) first = error;
  }
  std::string tried;
  for (const char* candidate : names) tried += (tried.empty() ? "" : ", ") + quoted(candidate);
  if (first.code == kSuccess) return fail("OpenHaptics has no device {}; name the one of its set-up (Touch_Setup) with --device-id", tried);
  return tl::unexpected(describe(first, "cannot open " + tried));
}

Result<Schedule> Session::start(Callback callback, void* data) {
  const std::lock_guard lock(mutex_);
  const Schedule schedule = hd_.schedule_asynchronous(callback, data, kHighestPriority);
  if (users_ == 0) hd_.start_scheduler();
  if (const ErrorInfo error = hd_.get_error(); error.code != kSuccess && is_device_error(error.code)) {
    if (users_ == 0) hd_.stop_scheduler();
    hd_.unschedule(schedule);
    return tl::unexpected(describe(error, "cannot start its scheduler"));
  }
  ++users_;
  return schedule;
}

void Session::close(Handle device, Schedule schedule) {
  const std::lock_guard lock(mutex_);
  --users_;
  if (users_ == 0) hd_.stop_scheduler();
  hd_.unschedule(schedule);
  hd_.disable_device(device);
  forget_errors(hd_);
}

}  // namespace hapton::hd
