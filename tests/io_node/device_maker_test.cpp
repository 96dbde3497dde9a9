#include "io_node/device_maker.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

namespace hapton {
namespace {

using ::testing::HasSubstr;

TEST(DeviceMaker, makes_what_is_named) {
  EXPECT_EQ((*make_device({}))->name(), "simulated");
  IoOptions options;
  options.device = "replay";
  options.trajectory = testing::TempDir() + "device_maker_test.csv";
  std::ofstream(options.trajectory) << "t_s,x_m,y_m,z_m\n0,1,2,3\n";
  EXPECT_EQ((*make_device(options))->name(), "replay");
}

TEST(DeviceMaker, says_what_is_missing) {
  IoOptions options;
  options.trajectory = "t.csv";
  EXPECT_THAT(make_device(options).error().what, HasSubstr("--device replay"));
  options.device = "replay";
  EXPECT_THAT(make_device(options).error().what, HasSubstr("t.csv"));
  options.trajectory = "";
  EXPECT_THAT(make_device(options).error().what, HasSubstr("--trajectory"));
  options.device = "sofa";
  EXPECT_THAT(make_device(options).error().what, HasSubstr("sofa"));
}

}  // namespace
}  // namespace hapton
