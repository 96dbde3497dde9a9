#include "link/settings_request.h"

#include <gtest/gtest.h>

#include <string>

namespace hapton {
namespace {

TEST(SettingsRequests, HoldWhatIsToChangeAndNothingElse) {
  const auto request = make_settings_request(
      {.rate_hz = 2000.0, .method = "smooth", .object = "lid", .material = {.given = MaterialChange::kDamping, .damping_ns_per_m = 0.5}});
  ASSERT_TRUE(request) << request.error().what;
  EXPECT_TRUE(request->has_settings);
  EXPECT_EQ(request->settings.servo_rate_hz, 2000.0);
  EXPECT_STREQ(request->settings.method.data(), "smooth");
  EXPECT_NE(request->settings.method_request, 0U);
  EXPECT_FALSE(request->settings.report_now || request->settings.reset_faults);
  ASSERT_TRUE(request->material);
  EXPECT_STREQ(request->material->object.data(), "lid");
  EXPECT_NE(request->material->request, 0U);
  EXPECT_EQ(request->material->change.given, MaterialChange::kDamping);
  EXPECT_EQ(request->material->change.damping_ns_per_m, 0.5);
}

TEST(SettingsRequests, AMaterialAloneNeedsNoSettings) {
  const auto request = make_settings_request({.material = {.given = MaterialChange::kStiffness, .stiffness_n_per_m = 300.0}});
  ASSERT_TRUE(request && request->material);
  EXPECT_FALSE(request->has_settings);
  EXPECT_EQ(request->material->object[0], '\0');
  EXPECT_EQ(request->settings.method_request, 0U);
  const auto fault = make_settings_request({.resets_faults = true});
  ASSERT_TRUE(fault);
  EXPECT_TRUE(fault->has_settings && fault->settings.reset_faults && !fault->material);
}

TEST(SettingsRequests, ANameThatIsTooLongIsOneLine) {
  const MaterialChange stiffer{.given = MaterialChange::kStiffness, .stiffness_n_per_m = 300.0};
  for (const SettingsChange& change :
       {SettingsChange{.method = std::string(16, 'm')}, SettingsChange{.object = std::string(256, 'o'), .material = stiffer}}) {
    const auto made = make_settings_request(change);
    ASSERT_FALSE(made);
    EXPECT_NE(made.error().what.find("at most"), std::string::npos) << made.error().what;
    EXPECT_EQ(made.error().what.find('\n'), std::string::npos);
  }
}

}  // namespace
}  // namespace hapton
