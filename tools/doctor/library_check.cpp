#include "tools/doctor/library_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "devices/vendor_library.h"
#include "tools/doctor/plugged_device.h"
#include "tools/doctor/run_in_child.h"

namespace hapton::doctor {
namespace {

constexpr double kLoadTimeoutS = 10.0;  // for the process that loads a library; a free choice

// True if the loader reports that the file itself is missing, not one of its dependencies.
bool is_absent(const LibraryFailure& failure) { return failure.error.starts_with(failure.file + ": cannot open shared object file"); }

// A plugged-in device that this library drives; null: there is none.
const PluggedDevice* find_device_of(const std::vector<PluggedDevice>& devices, std::string_view library) {
  const auto found = std::find_if(devices.begin(), devices.end(), [&](const PluggedDevice& d) { return d.library == library; });
  return found == devices.end() ? nullptr : &*found;
}

std::string describe_environment(const Machine& machine, const KnownVendorLibrary& library) {
  std::string text;
  for (const std::string_view variable : library.environment) {
    const std::string value = machine.environment(variable);
    if (!value.empty()) text += fmt::format(", {}={}", variable, value);
  }
  return text;
}

Finding explain_failure(const KnownVendorLibrary& library, const LibraryReply& reply, const PluggedDevice* device) {
  const std::string name(library.name);
  const auto informative_failure = std::find_if_not(reply.failures.begin(), reply.failures.end(), is_absent);
  if (informative_failure != reply.failures.end()) return problem(name, informative_failure->error, informative_failure->hint);
  if (device != nullptr) {
    const std::string reason = reply.failures.empty() ? "" : ": " + reply.failures.front().error;
    return problem(name, fmt::format("{} needs it, and it is not here{}", device->name, reason), fmt::format("install {}", library.source));
  }
  return note(name, fmt::format("not installed; it is for {}", library.devices));
}

Finding check_library(const Machine& machine, const KnownVendorLibrary& library, const std::vector<PluggedDevice>& devices) {
  const std::string name(library.name);
  if (!machine.queries().library) return note(name, "not checked");
  const LibraryReply reply = machine.queries().library(library.name);
  if (!reply.crash.empty())
    return problem(name, fmt::format("loading it fails: {}", reply.crash), fmt::format("reinstall it: {}", library.source));
  if (reply.file.empty()) return explain_failure(library, reply, find_device_of(devices, library.name));
  return good(name, fmt::format("{} loads{}; io_node --device {}", reply.file, describe_environment(machine, library), library.device));
}

}  // namespace

Findings check_libraries(const Machine& machine) {
  Findings findings;
  const std::vector<PluggedDevice> devices = find_plugged_devices(machine);
  for (const KnownVendorLibrary& library : known_vendor_libraries()) findings.push_back(check_library(machine, library, devices));
  return findings;
}

LibraryReply try_vendor_library(std::string_view name) {
  const auto libraries = known_vendor_libraries();
  const auto library = std::find_if(libraries.begin(), libraries.end(), [&](const KnownVendorLibrary& l) { return l.name == name; });
  if (library == libraries.end()) return {};
  const ChildReply child_reply = run_in_child(
      [&] {
        std::vector<FailedLoad> failures;
        const VendorLibrary loaded = VendorLibrary::try_open(*library, "", failures);
        nlohmann::json json = {{"file", loaded.file()}, {"failures", nlohmann::json::array()}};
        for (const FailedLoad& failure : failures) json["failures"].push_back({failure.file, failure.error, failure.hint});
        return json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
      },
      kLoadTimeoutS);
  LibraryReply reply;
  reply.crash = child_reply.failure;
  const auto json = nlohmann::json::parse(child_reply.text, nullptr, false);
  if (!json.is_object()) return reply;
  reply.file = json.at("file");
  for (const auto& failure : json.at("failures")) reply.failures.push_back({failure.at(0), failure.at(1), failure.at(2)});
  return reply;
}

}  // namespace hapton::doctor
