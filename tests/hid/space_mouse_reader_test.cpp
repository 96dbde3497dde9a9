#include "hid/space_mouse_reader.h"

#include <gtest/gtest.h>

#include "tests/support/fake_hid.h"
#include "tests/support/patience.h"

namespace hapton {
namespace {

const FakeHid::Bytes kPushed = {1, 0x5e, 0x01, 0, 0, 0, 0};  // x: 350

TEST(SpaceMouseReader, ReportsTheCapUntilItIsUnpluggedAndAgainAfterwards) {
  FakeHid hid;
  SpaceMouseReader reader(hid.opener());
  ASSERT_TRUE(reader.open());
  SteadyClock clock;
  EXPECT_TRUE(reader.state(clock.now_ns()).is_at_rest());
  EXPECT_TRUE(reader.is_there());
  const auto is_pushed = [&] {
    if (hid.is_drained()) hid.send(kPushed);
    return reader.state(clock.now_ns()).push.x() == 1.0;
  };
  EXPECT_TRUE(wait_until(is_pushed));
  hid.unplug();
  EXPECT_TRUE(wait_until([&] { return reader.state(clock.now_ns()).is_at_rest() && !reader.is_there(); }));
  hid.plug_in();
  EXPECT_TRUE(wait_until(is_pushed));
  EXPECT_TRUE(reader.is_there());
}

TEST(SpaceMouseReader, WithoutADeviceSaysWhy) {
  FakeHid hid;
  hid.unplug();
  SpaceMouseReader reader(hid.opener());
  EXPECT_EQ(reader.open().error().what, "the fake device is not plugged in");
}

}  // namespace
}  // namespace hapton
