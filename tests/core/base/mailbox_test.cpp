#include "core/base/mailbox.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <string>
#include <thread>

namespace hapton {
namespace {

TEST(MailboxTest, StartsWithTheInitialValueAndNothingNew) {
  Mailbox<std::string> mailbox("initial");
  EXPECT_FALSE(mailbox.take());
  EXPECT_EQ(mailbox.value(), "initial");
}

TEST(MailboxTest, TheNewestWins) {
  Mailbox<int> mailbox;
  mailbox.publish(1);
  mailbox.publish(2);
  EXPECT_TRUE(mailbox.take());
  EXPECT_EQ(mailbox.value(), 2);
  EXPECT_FALSE(mailbox.take());
  EXPECT_EQ(mailbox.value(), 2);
  mailbox.publish(3);
  EXPECT_TRUE(mailbox.take());
  EXPECT_EQ(mailbox.value(), 3);
}

TEST(MailboxTest, ADraftIsNotSeenBeforeItIsPublished) {
  Mailbox<int> mailbox(7);
  mailbox.draft() = 8;
  EXPECT_FALSE(mailbox.take());
  EXPECT_EQ(mailbox.value(), 7);
  mailbox.publish_draft();
  EXPECT_TRUE(mailbox.take());
  EXPECT_EQ(mailbox.value(), 8);
  EXPECT_EQ(Mailbox<int>().value(), 0);
}

// The writer, the reader and the exchange between them have a slot each, however often either of the two is called.
TEST(MailboxTest, EachSideHasItsOwnSlot) {
  Mailbox<int> mailbox(0);
  std::uint32_t state = 12345;
  int published = 0;
  int last_taken = 0;
  for (int n = 0; n < 1000; ++n) {
    state = state * 1664525U + 1013904223U;
    const bool writes = (state >> 24) % 3 != 0;
    if (writes) {
      const int readers_value = mailbox.value();
      mailbox.draft() = -1;
      EXPECT_EQ(mailbox.value(), readers_value);
      mailbox.publish(++published);
      EXPECT_EQ(mailbox.value(), readers_value);
    } else {
      EXPECT_EQ(mailbox.take(), published != last_taken);
      last_taken = published;
      EXPECT_EQ(mailbox.value(), published);
    }
  }
  EXPECT_GT(published, 300);
}

// The reader may change the value that it has taken in place: its slot is not shared.
TEST(MailboxTest, TheReaderMayWorkInPlace) {
  Mailbox<std::string> mailbox("a");
  mailbox.value() += "b";
  EXPECT_EQ(mailbox.value(), "ab");
  mailbox.publish("c");
  EXPECT_EQ(mailbox.value(), "ab");
  EXPECT_TRUE(mailbox.take());
  EXPECT_EQ(mailbox.value(), "c");
}

TEST(MailboxTest, TheReadersValueStaysWhileTheWriterGoesOn) {
  Mailbox<int> mailbox;
  mailbox.publish(1);
  ASSERT_TRUE(mailbox.take());
  const int& readers_value = mailbox.value();
  for (int i = 2; i < 10; ++i) {
    mailbox.draft() = i;
    mailbox.publish_draft();
    EXPECT_EQ(readers_value, 1);
  }
  EXPECT_TRUE(mailbox.take());
  EXPECT_EQ(mailbox.value(), 9);
}

// Counts the values that are torn, and those that are not newer than the value before.
TEST(MailboxTest, TwoThreadsNeverSeeHalfAValueNorAnOlderOne) {
  using Large = std::array<std::uint64_t, 64>;
  constexpr std::uint64_t kLast = 1'000'000;
  Mailbox<Large> mailbox;
  std::thread writer([&] {
    for (std::uint64_t i = 1; i <= kLast; ++i) {
      mailbox.draft().fill(i);
      mailbox.publish_draft();
    }
  });
  std::uint64_t newest = 0;
  std::uint64_t torn_count = 0;
  std::uint64_t older_count = 0;
  while (newest < kLast) {
    if (!mailbox.take()) {
      std::this_thread::yield();
      continue;
    }
    const Large& value = mailbox.value();
    torn_count += std::all_of(value.begin(), value.end(), [&](std::uint64_t x) { return x == value[0]; }) ? 0 : 1;
    older_count += value[0] <= newest ? 1 : 0;
    newest = value[0];
  }
  writer.join();
  EXPECT_EQ(torn_count, 0U);
  EXPECT_EQ(older_count, 0U);
}

}  // namespace
}  // namespace hapton
