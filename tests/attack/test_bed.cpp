#include "tests/attack/test_bed.h"

#include <sys/resource.h>

#include <algorithm>

#include "runtime/clock.h"

namespace hapton::attack {
namespace {

using process::Program;

constexpr double kPatienceS = 30.0;
// LimitRTTIME of deploy/systemd/hapton-io.service.
constexpr rlim_t kUnitRealtimeLimitUs = 500'000;

}  // namespace

bool wait_until(const std::function<bool()>& holds) {
  SteadyClock clock;
  const std::int64_t end_ns = clock.now_ns() + static_cast<std::int64_t>(1e9 * kPatienceS);
  for (; clock.now_ns() < end_ns; clock.sleep_until_ns(clock.now_ns() + 20 * kNanosecondsPerMillisecond)) {
    if (holds()) return true;
  }
  return false;
}

TestBed::TestBed(const std::string& touch) : touch_(touch) {
  const std::string out = folder().string() + "/out";
  rlimit before = {};
  ::getrlimit(RLIMIT_RTTIME, &before);
  const rlimit unit_limit = {.rlim_cur = std::min(kUnitRealtimeLimitUs, before.rlim_max), .rlim_max = before.rlim_max};
  ::setrlimit(RLIMIT_RTTIME, &unit_limit);
  io_ = std::make_unique<Program>(
      "io_node", std::vector<std::string>{"--bind", hub_, "--device", "simulated", "--out", out, "--flight", "off", "--touch", touch},
      folder());
  ::setrlimit(RLIMIT_RTTIME, &before);
  haptics_ = std::make_unique<Program>(
      "haptics_node", std::vector<std::string>{"--hub", hub_, "--scene", std::string(HAPTON_SOURCE_DIR) + "/scenes/car_front.toml"},
      folder());
}

std::string TestBed::await_contact() {
  if (!wait_until([&] { return observer_.attach(io_->pid()) || !io_->is_running(); }) || !io_->is_running()) {
    return "io_node does not start: " + io_->err();
  }
  if (!haptics_->is_running()) return "haptics_node does not start: " + haptics_->err();
  if (touch_ == "patch" && !wait_until([&] { return has_patches(); })) return "no force from patches within 30 s";
  return observer_.await_force(kForceN, kPatienceS) ? "" : "no force came within 30 s";
}

bool TestBed::has_patches() {
  const auto count = [&] {
    const auto report = request_report();
    return report.is_object() ? report.at("counters").value("local_forces", 0.0) : 0.0;
  };
  const double before = count();
  return count() > before + 20.0;
}

std::string TestBed::haptics_address() const {
  const std::string log = io_->out() + io_->err();
  constexpr std::string_view kWords = "haptics joined from ";
  const std::size_t found = log.rfind(kWords);
  if (found == std::string::npos) return "";
  const std::size_t begin = found + kWords.size();
  return log.substr(begin, log.find_first_of(" \n", begin) - begin);
}

std::string TestBed::capture() {
  const std::string captured = (folder() / "captured").string();
  const std::string relay_address = "127.0.0.1:" + process::find_free_port();
  Program listening("hapton_flood", {"--to", hub_, "--listen", relay_address, "--capture", captured, "--seconds", "1"}, folder());
  (void)process::run("hapton", {"set", "--hub", relay_address, "--rate", "1000"}, folder(), process::Seconds(10));
  const auto ended = listening.wait(process::kPatience);
  return ended && ended->exit_code == 0 ? captured : "";
}

nlohmann::json TestBed::request_report() {
  const auto path = folder() / "out" / "report.json";
  std::filesystem::remove(path);
  io_->send_signal(SIGUSR1);
  nlohmann::json report;
  wait_until([&] {
    if (!io_->is_running()) return true;
    if (!std::filesystem::exists(path)) return false;
    report = nlohmann::json::parse(process::read_text(path), nullptr, false);
    return report.is_object();
  });
  return report;
}

}  // namespace hapton::attack
