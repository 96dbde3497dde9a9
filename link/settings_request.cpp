#include "link/settings_request.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "link/random_id.h"

namespace hapton {
namespace {

// How long to wait for the confirmation of each request. Choices: as long as a person would wait.
constexpr std::int64_t kRatePatienceNs = 2 * kNanosecondsPerSecond;
constexpr std::int64_t kSetupPatienceNs = 3 * kNanosecondsPerSecond;   // a haptics node sends its setup once a second
constexpr std::int64_t kBuildPatienceNs = 60 * kNanosecondsPerSecond;  // millions of triangles take some seconds
constexpr std::int64_t kMaterialPatienceNs = 5 * kNanosecondsPerSecond;
constexpr std::int64_t kRepeatSettingNs = kNanosecondsPerSecond / 2;  // a datagram may be lost

std::uint32_t make_request_number() { return static_cast<std::uint32_t>(make_random_id()) | 1U; }

// Sends requests, keeps the replies, and waits until they confirm the change.
class SettingsTalk {
 public:
  SettingsTalk(HubClient& client, const Clock& clock) : client_(client), clock_(clock) {}

  bool confirm_rate(double rate_hz);
  Result<std::string> confirm_method(const Settings& settings);
  Result<std::string> confirm_material(const MaterialRequest& request);

  // Receives from the hub until the condition holds or the time is over, and keeps what the haptics node sends.
  template <class Condition>
  bool wait_until(std::int64_t timeout_ns, Condition&& holds) {
    const std::int64_t end_ns = clock_.now_ns() + timeout_ns;
    Datagram datagram;
    while (!holds()) {
      const std::int64_t now_ns = clock_.now_ns();
      if (now_ns >= end_ns) return false;
      if (!client_.receive(datagram, now_ns + 20 * kNanosecondsPerMillisecond)) continue;
      if (const auto* setup = std::get_if<HapticsSetup>(&datagram.message)) setup_ = *setup;
      if (const auto* materials = std::get_if<MaterialState>(&datagram.message)) materials_ = *materials;
    }
    return true;
  }

 private:
  // Sends the request twice a second until the reply comes, because a datagram may be lost.
  template <class Request, class Condition>
  bool repeat_until(std::int64_t timeout_ns, const Request& request, Condition&& has_reply) {
    std::int64_t next_request_ns = clock_.now_ns() + kRepeatSettingNs;
    return wait_until(timeout_ns, [&] {
      if (has_reply()) return true;
      if (clock_.now_ns() >= next_request_ns) {
        client_.send(request);
        next_request_ns += kRepeatSettingNs;
      }
      return false;
    });
  }

  HubClient& client_;
  const Clock& clock_;
  std::optional<HapticsSetup> setup_;
  std::optional<MaterialState> materials_;
};

// Each welcome of the hub names its present servo rate.
bool SettingsTalk::confirm_rate(double rate_hz) {
  const auto holds = [&] { return rate_hz == 0.0 || std::abs(client_.servo_rate_hz() - rate_hz) <= 1e-3 * rate_hz; };
  return repeat_until(kRatePatienceNs, Settings{.servo_rate_hz = rate_hz}, holds);
}

// Waits for the haptics node's reply to the request for a method.
Result<std::string> SettingsTalk::confirm_method(const Settings& settings) {
  const char* const method = settings.method.data();
  if (!wait_until(kSetupPatienceNs, [&] { return setup_.has_value(); })) {
    return fail("no haptics node has joined the hub, so no method is in use; start haptics_node");
  }
  const Settings again{.method = settings.method, .method_request = settings.method_request};
  if (!repeat_until(kBuildPatienceNs, again, [&] { return setup_->method_request == settings.method_request; })) {
    return fail(
        "the haptics node does not confirm method {}: it is still building it, another method was requested since, or it is another "
        "build",
        method);
  }
  if (setup_->rejection[0] != '\0')
    return fail("the haptics node rejected it: {}; the current method stays in use", setup_->rejection.data());
  return fmt::format("method {} in use", method);
}

Result<std::string> SettingsTalk::confirm_material(const MaterialRequest& request) {
  if (!wait_until(kSetupPatienceNs, [&] { return setup_.has_value(); })) {
    return fail("no haptics node has joined the hub, so nothing can be touched; start haptics_node");
  }
  const auto has_reply = [&] { return materials_ && materials_->request == request.request; };
  if (!repeat_until(kMaterialPatienceNs, request, has_reply)) {
    return fail("the haptics node does not confirm the material: another change was requested since, or it is another version of Hapton");
  }
  if (materials_->rejection[0] != '\0') {
    return fail("the haptics node rejected it: {}; no material is changed", materials_->rejection.data());
  }
  return request.object[0] == '\0' ? std::string("material of all objects in use")
                                   : fmt::format("material of '{}' in use", request.object.data());
}

}  // namespace

Result<SettingsRequest> make_settings_request(const SettingsChange& change) {
  SettingsRequest request;
  Settings& settings = request.settings;
  settings.servo_rate_hz = change.rate_hz;
  settings.report_now = change.writes_report;
  settings.reset_faults = change.resets_faults;
  if (change.method.size() >= settings.method.size()) {
    return fail("the name of a method has at most {} bytes, not {}", settings.method.size() - 1, change.method.size());
  }
  std::copy(change.method.begin(), change.method.end(), settings.method.begin());
  if (!change.method.empty()) settings.method_request = make_request_number();
  request.has_settings = change.rate_hz != 0.0 || !change.method.empty() || change.writes_report || change.resets_faults;
  if (change.material.fields == 0) return request;
  MaterialRequest& material = request.material.emplace();
  if (change.object.size() >= material.object.size()) {
    return fail("the name of an object has at most {} bytes, not {}", material.object.size() - 1, change.object.size());
  }
  material.change = change.material;
  std::copy(change.object.begin(), change.object.end(), material.object.begin());
  material.request = make_request_number();
  return request;
}

Result<std::string> apply_settings(HubClient& client, const Clock& clock, const SettingsRequest& request, std::string_view hub) {
  SettingsTalk talk(client, clock);
  const bool is_sent = (!request.has_settings || client.send(request.settings)) && (!request.material || client.send(*request.material));
  if (!is_sent) return fail("the settings could not be sent to {}", hub);
  if (!talk.confirm_rate(request.settings.servo_rate_hz)) {
    return fail("the hub at {} stays at {} Hz; choose {} to {} Hz", hub, client.servo_rate_hz(), kMinServoRateHz, kMaxServoRateHz);
  }
  std::string text = fmt::format("hub {}: servo rate {} Hz", hub, client.servo_rate_hz());
  if (request.settings.method_request != 0) {
    const auto method = talk.confirm_method(request.settings);
    if (!method) return method;
    text += "; " + *method;
  }
  if (request.material) {
    const auto material = talk.confirm_material(*request.material);
    if (!material) return material;
    text += "; " + *material;
  }
  return text;
}

}  // namespace hapton
