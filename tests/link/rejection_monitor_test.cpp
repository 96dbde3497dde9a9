#include "link/rejection_monitor.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

#include "link/memory_endpoint.h"
#include "tests/support/time_units.h"

namespace hapton {
namespace {

const Address kFirstSource = memory_address(66, 6);
const Address kOtherSource = memory_address(67, 6);

void note(RejectionMonitor& monitor, Rejection rejection, const Address& from, int count) {
  for (int i = 0; i < count; ++i) monitor.note(rejection, from);
}

TEST(RejectionMonitorTest, SaysNothingOfAFew) {
  RejectionMonitor monitor;
  EXPECT_FALSE(monitor.take(kSecond));
  note(monitor, Rejection::wrong_key, kFirstSource, 900);
  EXPECT_FALSE(monitor.take(2 * kSecond));
  note(monitor, Rejection::replayed_handshake, kFirstSource, 20);  // two nodes of one host that send requests at the same time
  EXPECT_FALSE(monitor.take(3 * kSecond));
}

// Nodes repeat no handshake, so a peer that repeats a hundred a second is reported. Of other kinds, up to a thousand are not.
TEST(RejectionMonitorTest, NamesASlowFloodOfHandshakes) {
  for (const Rejection rejection : {Rejection::replayed_handshake, Rejection::too_many_handshakes}) {
    RejectionMonitor monitor;
    monitor.take(kSecond);
    note(monitor, rejection, kFirstSource, 100);
    note(monitor, Rejection::unknown_session, kOtherSource, 900);
    const auto flood = monitor.take(2 * kSecond);
    ASSERT_TRUE(flood);
    EXPECT_EQ(flood->rejection, rejection);
    EXPECT_EQ(flood->from, kFirstSource);
  }
}

TEST(RejectionMonitorTest, NotesMoreThanOneAtATime) {
  RejectionMonitor monitor;
  monitor.take(kSecond);
  monitor.note(Rejection::oversized, kFirstSource, 700'000);
  const auto flood = monitor.take(2 * kSecond);
  ASSERT_TRUE(flood);
  EXPECT_EQ(flood->rejection, Rejection::oversized);
  EXPECT_DOUBLE_EQ(flood->per_second, 700'000.0);
}

TEST(RejectionMonitorTest, NamesAFloodOnceASecondAndTheWorstAlone) {
  RejectionMonitor monitor;
  monitor.take(kSecond);
  note(monitor, Rejection::malformed, kOtherSource, 2000);
  note(monitor, Rejection::replayed_handshake, kFirstSource, 50'000);
  EXPECT_FALSE(monitor.take(kSecond + kSecond / 2));
  const auto flood = monitor.take(2 * kSecond);
  ASSERT_TRUE(flood);
  EXPECT_EQ(flood->rejection, Rejection::replayed_handshake);
  EXPECT_EQ(flood->from, kFirstSource);
  EXPECT_FALSE(flood->is_from_several);
  EXPECT_DOUBLE_EQ(flood->per_second, 50'000.0);
  EXPECT_FALSE(monitor.take(2 * kSecond));
  EXPECT_FALSE(monitor.take(3 * kSecond)) << "it is over";
}

// A filter in the kernel drops most of a flood unseen and lets a random few through.
TEST(RejectionMonitorTest, FilteredDatagramsCountForEachKindInItsShare) {
  RejectionMonitor monitor;
  monitor.take(kSecond);
  note(monitor, Rejection::malformed, kFirstSource, 300);
  note(monitor, Rejection::unknown_session, kOtherSource, 100);
  monitor.note_filtered(99'600);
  const auto flood = monitor.take(2 * kSecond);
  ASSERT_TRUE(flood);
  EXPECT_EQ(flood->rejection, Rejection::malformed);
  EXPECT_NEAR(flood->per_second, 75'000.0, 1e-6);
  EXPECT_TRUE(flood->is_mostly_filtered);
  monitor.note_filtered(1000);
  EXPECT_FALSE(monitor.take(3 * kSecond)) << "it is unknown which kind was filtered";
  note(monitor, Rejection::malformed, kFirstSource, 5000);
  const auto next = monitor.take(4 * kSecond);
  ASSERT_TRUE(next);
  EXPECT_NEAR(next->per_second, 5000.0, 1e-6);
  EXPECT_FALSE(next->is_mostly_filtered);
}

TEST(RejectionMonitorTest, ARateIsOfTheTimeThatPassed) {
  RejectionMonitor monitor;
  monitor.take(0);
  note(monitor, Rejection::forged, kFirstSource, 5000);
  EXPECT_FALSE(monitor.take(10 * kSecond));
}

TEST(RejectionMonitorTest, SaysWhenThereAreSeveralSources) {
  RejectionMonitor monitor;
  monitor.take(kSecond);
  note(monitor, Rejection::forged, kFirstSource, 1);
  note(monitor, Rejection::forged, kOtherSource, 5000);
  const auto flood = monitor.take(2 * kSecond);
  ASSERT_TRUE(flood);
  EXPECT_EQ(flood->from, kOtherSource);
  EXPECT_TRUE(flood->is_from_several);
}

TEST(RejectionMonitorTest, EveryRejectionHasItsOwnText) {
  std::set<std::string_view> texts;
  for (std::size_t n = 0; n < kRejections; ++n) texts.insert(describe(static_cast<Rejection>(n)));
  EXPECT_EQ(texts.size(), kRejections);
}

}  // namespace
}  // namespace hapton
