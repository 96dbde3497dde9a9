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

TEST(MailboxTest, TheReadersValueStaysWhileTheWriterGoesOn) {
  Mailbox<int> mailbox;
  mailbox.publish(1);
  ASSERT_TRUE(mailbox.take());
  const int& held = mailbox.value();
  for (int i = 2; i < 10; ++i) {
    mailbox.draft() = i;
    mailbox.publish_draft();
    EXPECT_EQ(held, 1);
  }
  EXPECT_TRUE(mailbox.take());
  EXPECT_EQ(mailbox.value(), 9);
}

// Torn or older values are detected at once.
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
  std::uint64_t torn = 0;
  std::uint64_t backwards = 0;
  while (newest < kLast) {
    if (!mailbox.take()) {
      std::this_thread::yield();
      continue;
    }
    const Large& value = mailbox.value();
    torn += std::all_of(value.begin(), value.end(), [&](std::uint64_t x) { return x == value[0]; }) ? 0 : 1;
    backwards += value[0] <= newest ? 1 : 0;
    newest = value[0];
  }
  writer.join();
  EXPECT_EQ(torn, 0U);
  EXPECT_EQ(backwards, 0U);
}

}  // namespace
}  // namespace hapton
