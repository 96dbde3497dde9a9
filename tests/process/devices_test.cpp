// Several devices in one io_node.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <regex>

#include "tests/process/program.h"
#include "tests/process/system.h"

namespace hapton::process {
namespace {

using ::testing::HasSubstr;

// Two simulated hands on one scene, a haptics node for each.
struct TwoHands : testing::Test {
  void SetUp() override {
    std::ofstream(system.folder() / "devices.toml") << device("left", -0.02) << device("right", 0.02);
    io = std::make_unique<Program>(
        "io_node",
        std::vector<std::string>{"--devices", (system.folder() / "devices.toml").string(), "--out", (system.folder() / "out").string()},
        system.folder());
    ASSERT_TRUE(System::wait_until([&] { return io->out().find("right: hub on ") != std::string::npos || !io->is_running(); }));
  }
  std::string device(const std::string& name, double x_m) {
    hubs[name] = "127.0.0.1:" + find_free_port();
    return "[[device]]\nname = \"" + name + "\"\ndevice = \"simulated\"\nbind = \"" + hubs[name] + "\"\nposition_m = [" +
           std::to_string(x_m) + ", 0, 0]\n";
  }
  void start_haptics(const std::string& name) {
    haptics[name] = std::make_unique<Program>(
        "haptics_node", std::vector<std::string>{"--hub", hubs.at(name), "--scene", (system.folder() / "cube.toml").string()},
        system.folder());
  }
  Json report_of(const std::string& name) const {
    return Json::parse(read_text(system.folder() / "out" / name / "report.json"), nullptr, false);
  }
  // Requests reports until the condition holds for both hands. False: it never did, or io_node has ended.
  bool wait_for(const std::function<bool(const Json& left, const Json& right)>& holds) {
    bool has_held = false;
    (void)System::wait_until([&] {
      if (!io->is_running()) return true;
      io->send_signal(SIGUSR1);
      const Json left = report_of("left");
      const Json right = report_of("right");
      return has_held = left.is_object() && right.is_object() && holds(left, right);
    });
    return has_held;
  }

  System system;
  std::map<std::string, std::string> hubs;
  std::unique_ptr<Program> io;
  std::map<std::string, std::unique_ptr<Program>> haptics;
};

TEST_F(TwoHands, TouchEachByItself) {
  start_haptics("left");
  start_haptics("right");
  ASSERT_TRUE(wait_for([](const Json& left, const Json& right) { return has_contact(left) && has_contact(right); }))
      << io->out() << io->err();
  // The right hand continues when the left one's haptics node is gone.
  haptics["left"]->kill();
  ASSERT_TRUE(wait_for([](const Json& left, const Json&) { return count(left, "command_timeouts") > 0; })) << io->err();
  const std::int64_t contact_samples = count(report_of("right"), "contact_samples");
  ASSERT_TRUE(wait_for([&](const Json&, const Json& right) { return count(right, "contact_samples") > contact_samples; })) << io->err();
  io->send_signal(SIGTERM);
  const auto ended = io->wait(kPatience);
  ASSERT_TRUE(ended) << "io_node does not end";
  EXPECT_EQ(ended->exit_code, 0) << ended->err;
  for (const char* name : {"left", "right"}) {
    EXPECT_THAT(ended->out, HasSubstr(std::string("--- ") + name));
    expect_sane(report_of(name));
    EXPECT_EQ(report_of(name).at("notes").at("name"), name);
  }
}

#ifdef HAPTON_WITH_VISION
TEST_F(TwoHands, AreShownInOnePicture) {
  const VirtualDisplay display;
  Program vision(
      "vision_node",
      {"--hub", hubs.at("left"), "--hub", hubs.at("right"), "--scene", (system.folder() / "cube.toml").string(), "--size", "320x240"},
      system.folder(), display.name());
  EXPECT_TRUE(wait_for([](const Json& left, const Json& right) { return count(left, "drawn") > 3 && count(right, "drawn") > 3; }))
      << vision.err();
  vision.send_signal(SIGTERM);
  const auto ended = vision.wait(kPatience);
  ASSERT_TRUE(ended) << "vision_node does not end";
  EXPECT_EQ(ended->exit_code, 0) << ended->err;
  EXPECT_THAT(ended->err, HasSubstr("joined the other hand's hub"));
}
#endif

TEST_F(TwoHands, AreReportedByTheDoctor) {
  const std::string port = hubs["left"].substr(hubs["left"].find(':') + 1);
  const auto requested = run("hapton", {"doctor", "--only", "hub", "--only", "ports", "--port", port, "--json"}, system.folder());
  ASSERT_TRUE(requested);
  EXPECT_EQ(requested->exit_code, 0) << requested->out << requested->err;
  EXPECT_EQ(Json::parse(requested->out).at("schema"), "hapton.doctor/1");
  EXPECT_THAT(requested->out, HasSubstr("simulated, calibrated"));
  EXPECT_THAT(requested->out, HasSubstr("io_node has it (process " + std::to_string(io->pid())));
}

TEST(Doctor, ReportsByItsExitCode) {
  TestFolder folder;
  const std::string clock = (folder.path() / "root/sys/devices/system/clocksource/clocksource0").string();
  std::filesystem::create_directories(clock);
  const auto run_doctor = [&] {
    return run("hapton", {"doctor", "--root", (folder.path() / "root").string(), "--only", "clock"}, folder.path()).value_or(Ended{});
  };
  std::ofstream(clock + "/current_clocksource") << "tsc\n";
  EXPECT_EQ(run_doctor().exit_code, 0);
  std::ofstream(clock + "/current_clocksource") << "hpet\n";
  const Ended slow = run_doctor();
  EXPECT_EQ(slow.exit_code, 1);
  EXPECT_THAT(slow.out, HasSubstr("fix: "));
  for (const std::vector<std::string>& wrong :
       {std::vector<std::string>{"--only", "nonsense"}, {"--root", "/nowhere"}, {"--port", "0"}, {"stray"}}) {
    std::vector<std::string> words = {"doctor"};
    words.insert(words.end(), wrong.begin(), wrong.end());
    EXPECT_EQ(run("hapton", words, folder.path()).value_or(Ended{}).exit_code, 2) << wrong.front();
  }
}

// The name comes from an OpenGL context that the doctor has made current.
TEST(Doctor, NamesTheRendererOfADisplay) {
  TestFolder folder;
  const VirtualDisplay display;
  Program doctor("hapton", {"doctor", "--only", "display"}, folder.path(), display.name());
  ASSERT_TRUE(doctor.wait(kPatience)) << "still runs";
  EXPECT_TRUE(std::regex_search(doctor.out(), std::regex("renderer: [^ ,].*, OpenGL [0-9]+\\.[0-9]"))) << doctor.out() << doctor.err();
}

// Adds a folder in which the loader looks for libraries, as long as this object lives.
class LoaderPath {
 public:
  explicit LoaderPath(const std::string& folder) : previous_(::getenv("LD_LIBRARY_PATH") == nullptr ? "" : ::getenv("LD_LIBRARY_PATH")) {
    ::setenv("LD_LIBRARY_PATH", folder.c_str(), 1);
  }
  ~LoaderPath() { previous_.empty() ? ::unsetenv("LD_LIBRARY_PATH") : ::setenv("LD_LIBRARY_PATH", previous_.c_str(), 1); }

 private:
  std::string previous_;
};

TEST(Doctor, LoadsVendorsLibrariesAndNamesWhatTheyLack) {
  TestFolder folder;
  const auto run_doctor = [&](const std::string& libraries) {
    const LoaderPath path(std::string(HAPTON_BIN_DIR) + "/../tests/standins/" + libraries);
    return run("hapton", {"doctor", "--only", "libraries"}, folder.path()).value_or(Ended{});
  };
  const Ended loaded = run_doctor("openhaptics");
  EXPECT_EQ(loaded.exit_code, 0) << loaded.out << loaded.err;
  EXPECT_THAT(loaded.out, HasSubstr("OpenHaptics: libHD.so loads"));
  const Ended needy = run_doctor("needy");
  EXPECT_EQ(needy.exit_code, 1);
  EXPECT_THAT(needy.out, HasSubstr("OpenHaptics: libPhantomIOLib42.so: cannot open shared object file: No such file or directory"));
  EXPECT_THAT(needy.out, HasSubstr("fix: libHD.so exists, but needs libPhantomIOLib42.so"));
}

TEST(Devices, AFileThatIsWrongIsOneLine) {
  TestFolder folder;
  std::ofstream(folder.path() / "bad.toml") << "[[device]]\nname = \"left\"\ndevice = \"sofa\"\nbind = \"127.0.0.1:0\"\n";
  const auto ended = run("io_node", {"--devices", (folder.path() / "bad.toml").string()}, folder.path());
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->exit_code, 1);
  EXPECT_THAT(ended->err, HasSubstr("bad.toml:3: unknown device 'sofa'; choose one of simulated"));
  const auto both = run("io_node", {"--devices", (folder.path() / "bad.toml").string(), "--device", "simulated"}, folder.path());
  ASSERT_TRUE(both);
  EXPECT_EQ(both->exit_code, 2);
  EXPECT_THAT(both->err, HasSubstr("--devices"));
}

}  // namespace
}  // namespace hapton::process
