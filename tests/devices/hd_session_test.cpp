#include "devices/hd_session.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <deque>
#include <map>

namespace hapton::hd {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

// The calls that the stand-in for libHD got, and the errors it is to report. libHD's functions get no user data: hence a global pointer.
struct HdScript {
  std::deque<Enum> errors;
  std::map<std::string, std::vector<Enum>> opening_errors;  // errors of opening, by device name; without any, it opens
  std::vector<Enum> starting_errors;                        // errors of starting the scheduler
  std::vector<std::string> calls;
  bool gives_no_handle = false;
};
HdScript* active_script = nullptr;

Library scripted_library() {
  Library hd;
  hd.init_device = [](const char* name) -> Handle {
    const std::string device = name != nullptr ? name : "";
    active_script->calls.push_back("open " + device);
    const auto& errors = active_script->opening_errors[device];
    active_script->errors.insert(active_script->errors.end(), errors.begin(), errors.end());
    return errors.empty() && !active_script->gives_no_handle ? 7 : kInvalidHandle;
  };
  hd.get_error = [] {
    if (active_script->errors.empty()) return ErrorInfo{kSuccess, 0, 0};
    const Enum code = active_script->errors.front();
    active_script->errors.pop_front();
    return ErrorInfo{code, -42, 0};
  };
  hd.get_error_string = [](Enum) -> const char* { return nullptr; };
  hd.make_current_device = [](Handle) {};
  hd.disable_device = [](Handle) { active_script->calls.push_back("close"); };
  hd.schedule_asynchronous = [](Callback, void*, unsigned short) -> Schedule { return 5; };
  hd.unschedule = [](Schedule schedule) { active_script->calls.push_back("unschedule " + std::to_string(schedule)); };
  hd.start_scheduler = [] {
    active_script->calls.push_back("start with " + std::to_string(active_script->errors.size()) + " errors");
    active_script->errors.insert(active_script->errors.end(), active_script->starting_errors.begin(), active_script->starting_errors.end());
  };
  hd.stop_scheduler = [] { active_script->calls.push_back("stop"); };
  return hd;
}

struct HdSession : testing::Test {
  HdSession() { active_script = &script; }

  Result<Session::Attached> attach(const std::string& name) {
    script.calls.clear();
    return session.attach(
        name, [this](Handle) { return set_up; }, nullptr, nullptr);
  }

  HdScript script;
  Session session{scripted_library()};
  Result<void> set_up;
};

TEST_F(HdSession, ErrorsFromBeforeAreNotThoseOfTheDeviceThatIsOpened) {
  script.errors = {kCommError, kForceError};
  const auto attached = attach("Left");
  ASSERT_TRUE(attached) << attached.error().what;
  EXPECT_EQ(attached->device, 7U);
  EXPECT_EQ(attached->schedule, 5U);
  EXPECT_THAT(script.calls, ElementsAre("open Left", "start with 0 errors"));
}

// Errors of the name that was tried first do not count for the next name either.
TEST_F(HdSession, ErrorsOfOneNameDoNotAffectTheNext) {
  script.opening_errors["Default Device"] = {kCommError, kCommConfigError};
  const auto attached = attach("");
  ASSERT_TRUE(attached) << attached.error().what;
  EXPECT_THAT(script.calls, ElementsAre("open Default Device", "open Default PHANToM", "start with 0 errors"));
}

TEST_F(HdSession, ADeviceThatCannotBeOpenedLeavesNoErrorToTheOthers) {
  ASSERT_TRUE(attach("Left"));
  script.opening_errors["Right"] = {kCommError, kDeviceFault};
  const auto attached = attach("Right");
  ASSERT_FALSE(attached);
  EXPECT_THAT(attached.error().what, HasSubstr("OpenHaptics cannot open 'Right': HD_COMM_ERROR (0x302), internal code -42; "));
  EXPECT_THAT(script.calls, ElementsAre("stop", "open Right", "start with 0 errors"));
  EXPECT_TRUE(session.has_users());
}

TEST_F(HdSession, ADeviceThatCannotBeSetUpIsClosed) {
  set_up = fail("no such workspace");
  const auto attached = attach("Left");
  ASSERT_FALSE(attached);
  EXPECT_EQ(attached.error().what, "no such workspace");
  EXPECT_THAT(script.calls, ElementsAre("open Left", "close"));
  EXPECT_FALSE(session.has_users());
}

TEST_F(HdSession, ASchedulerThatDoesNotStartIsReportedAndNothingStaysOpen) {
  script.starting_errors = {kTimerError, kTimerError};
  const auto attached = attach("Left");
  ASSERT_FALSE(attached);
  EXPECT_THAT(attached.error().what, HasSubstr("OpenHaptics cannot start its scheduler: HD_TIMER_ERROR (0x304), internal code -42"));
  EXPECT_THAT(script.calls, ElementsAre("open Left", "start with 0 errors", "stop", "unschedule 5", "close"));
  EXPECT_FALSE(session.has_users());
  script.starting_errors.clear();
  EXPECT_TRUE(attach("Left")) << "its second error is not the next device's";
}

// The error may belong to another device, which checks for its errors itself.
TEST_F(HdSession, AnErrorWhileOthersTickIsNotThatOfTheScheduler) {
  ASSERT_TRUE(attach("Left"));
  script.starting_errors = {kCommError};
  EXPECT_TRUE(attach("Right"));
  EXPECT_THAT(script.calls, ElementsAre("stop", "open Right", "start with 0 errors"));
}

TEST_F(HdSession, NoHandleAndNoErrorIsNoDevice) {
  script.gives_no_handle = true;
  EXPECT_EQ(attach("Left").error().what, "OpenHaptics has no device 'Left'; give the name from its set-up (Touch_Setup) with --device-id");
  EXPECT_EQ(attach("").error().what,
            "OpenHaptics has no device 'Default Device', 'Default PHANToM', the library's default device; give the name from its set-up "
            "(Touch_Setup) with --device-id");
}

TEST_F(HdSession, TheLastDeviceStopsTheSchedulerAndAnotherStartsItAgain) {
  const auto left = attach("Left");
  const auto right = attach("Right");
  ASSERT_TRUE(left && right);
  script.calls.clear();
  session.detach(*left);
  EXPECT_THAT(script.calls, ElementsAre("stop", "unschedule 5", "close", "start with 0 errors"));
  script.calls.clear();
  session.detach(*right);
  EXPECT_THAT(script.calls, ElementsAre("stop", "unschedule 5", "close"));
  EXPECT_FALSE(session.has_users());
}

}  // namespace
}  // namespace hapton::hd
