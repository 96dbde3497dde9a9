#include "haptics_node/carve_sender.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "link/known_carves.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/time_units.h"

namespace hapton {
namespace {

constexpr std::uint32_t kSource = 7;

// The position of each carve gives its serial.
MadeCarve nth_carve(std::uint32_t serial) { return {.object = 0, .serial = serial, .carve = {Vec3::Zero(), Vec3(serial, 0, 0), 0.005}}; }

// A vision node's knowledge of the carves.
struct CarveViewer {
  KnownCarves known;
  std::vector<int> applied;  // at serial - 1: how often that carve was applied

  void take(const Carves& carves) {
    const KnownCarves::News news = known.take(carves, Arrival::newest);
    for (const Carves::One& one : news.carves) {
      const auto serial = static_cast<std::size_t>(one.to_m[0]);
      if (applied.size() < serial) applied.resize(serial);
      ++applied[serial - 1];
    }
  }
  std::size_t missing() const { return static_cast<std::size_t>(std::count(applied.begin(), applied.end(), 0)); }
};

struct CarveSenderTest : testing::Test {
  CarveSender sender{kSource, 100'000};
  std::vector<Carves> sent;
  std::int64_t now_ns = 0;

  void make_carves(std::uint32_t count) {
    for (std::uint32_t n = 0; n < count; ++n) sender.note(nth_carve(sender.newest() + 1));
  }
  void run_ms(int ms) {
    for (int n = 0; n < ms; ++n, now_ns += kMs) {
      if (const auto due = sender.take_due(now_ns)) sent.push_back(*due);
    }
  }
};

TEST_F(CarveSenderTest, ACarveIsSentAtOnceAndTwiceMore) {
  run_ms(100);
  EXPECT_TRUE(sent.empty());
  make_carves(1);
  run_ms(1);
  ASSERT_EQ(sent.size(), 1U);
  EXPECT_EQ(sent[0].source, kSource);
  EXPECT_EQ(sent[0].newest, 1U);
  EXPECT_EQ(sent[0].first, 1U);
  EXPECT_EQ(sent[0].count, 1U);
  EXPECT_EQ(sent[0].carves[0].to_m[0], 1.0F);
  run_ms(1000);
  EXPECT_EQ(sent.size(), 3U);
}

TEST_F(CarveSenderTest, ADatagramRepeatsTheNewestOfTheOneBefore) {
  make_carves(20);
  run_ms(1);
  make_carves(2);
  run_ms(5);
  ASSERT_EQ(sent.size(), 2U);
  EXPECT_EQ(sent[1].first, 20U - CarveSender::kOverlap + 1);
  EXPECT_EQ(sent[1].first + sent[1].count - 1, 22U);
}

TEST_F(CarveSenderTest, NeverMoreThan200DatagramsASecond) {
  for (int n = 0; n < 1000; ++n) {
    make_carves(3);
    sender.accept({.source = kSource, .complete = 0});
    run_ms(1);
  }
  EXPECT_LE(sent.size(), 200U);
  EXPECT_GE(sent.size(), 199U);
  EXPECT_GE(sent.back().newest, 2980U);
}

TEST_F(CarveSenderTest, NewAndRequestedOnesTakeTurns) {
  make_carves(3000);
  run_ms(1000);
  sent.clear();
  sender.accept({.source = kSource, .complete = 0});
  std::size_t with_new_carves = 0;
  for (int n = 0; n < 200; ++n) {
    make_carves(1);
    run_ms(1);
  }
  for (const Carves& carves : sent) with_new_carves += carves.first + carves.count - 1 > 3000 ? 1U : 0U;
  EXPECT_EQ(with_new_carves, sent.size() / 2);
  std::uint32_t next = 1;
  for (const Carves& carves : sent) {
    if (carves.first > 2900) continue;
    EXPECT_EQ(carves.first, next);
    next = carves.first + carves.count;
  }
  EXPECT_GT(next, 600U);
}

TEST_F(CarveSenderTest, AViewerThatJoinsLateGetsAllCarves) {
  make_carves(5000);
  run_ms(1500);
  sent.clear();
  CarveViewer late;
  late.take(sender.announce());
  for (int n = 0; n < 2000; ++n) {
    if (const auto request = late.known.take_request(now_ns)) sender.accept(*request);
    run_ms(1);
    for (const Carves& carves : sent) late.take(carves);
    sent.clear();
  }
  EXPECT_EQ(late.known.complete(), 5000U);
  EXPECT_EQ(late.missing(), 0U);
}

// Two of the three viewers join late, at different times; the link loses one datagram in three, in both directions.
TEST_F(CarveSenderTest, EachViewerGetsAllHoweverManyAreLost) {
  constexpr unsigned kSeed = 20261125;
  std::mt19937 random(kSeed);
  RecordProperty("seed", kSeed);
  const auto is_lost = [&] { return random() % 3 == 0; };
  std::vector<CarveViewer> viewers(3);
  for (int n = 0; n < 20'000; ++n) {
    if (n < 4000 && n % 3 == 0) make_carves(1);
    for (std::size_t v = 0; v < viewers.size(); ++v) {
      if (n < 2000 * static_cast<int>(v)) continue;
      if (n % 1000 == 0 && !is_lost()) viewers[v].take(sender.announce());
      const auto request = viewers[v].known.take_request(now_ns);
      if (request && !is_lost()) sender.accept(*request);
    }
    run_ms(1);
    for (const Carves& carves : sent) {
      for (std::size_t v = 0; v < viewers.size(); ++v) {
        if (n >= 2000 * static_cast<int>(v) && !is_lost()) viewers[v].take(carves);
      }
    }
    sent.clear();
  }
  for (const CarveViewer& viewer : viewers) {
    EXPECT_EQ(viewer.known.complete(), 1334U);
    EXPECT_EQ(viewer.missing(), 0U);
  }
}

TEST_F(CarveSenderTest, RequestsThatMakeNoSenseAreLeftOut) {
  make_carves(10);
  run_ms(500);
  sent.clear();
  sender.accept({.source = kSource + 1, .complete = 0});
  sender.accept({.source = kSource, .complete = 10});
  sender.accept({.source = kSource, .complete = 0xFFFFFFFF});
  run_ms(500);
  EXPECT_TRUE(sent.empty());
}

// The scene was read again, with other bodies to carve.
TEST_F(CarveSenderTest, SerialsThatBeginAgainAreOfOtherBodies) {
  make_carves(10);
  run_ms(500);
  sent.clear();
  sender.note(nth_carve(1));
  EXPECT_NE(sender.announce().source, kSource);
  EXPECT_NE(sender.announce().source, 0U);
  EXPECT_EQ(sender.newest(), 1U);
  run_ms(500);
  ASSERT_EQ(sent.size(), 3U);
  for (const Carves& carves : sent) {
    EXPECT_EQ(carves.source, sender.announce().source);
    EXPECT_EQ(carves.count, 1U);
  }
  sender.note(nth_carve(3));
  EXPECT_EQ(sender.newest(), 1U) << "one was left out";
}

TEST_F(CarveSenderTest, TheNumbersAreThoseThatAreCarved) {
  const Carve carve = rounded({Vec3(0.1, 0.2, 0.3), Vec3(-0.1, 1.0 / 3.0, 0.3), 0.007});
  sender.note({.object = 4, .serial = 1, .carve = carve});
  run_ms(1);
  ASSERT_EQ(sent.size(), 1U);
  const Carves::One& one = sent[0].carves[0];
  EXPECT_EQ(one.object, 4);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    EXPECT_EQ(one.from_m[axis], carve.from_m[static_cast<Eigen::Index>(axis)]);
    EXPECT_EQ(one.to_m[axis], carve.to_m[static_cast<Eigen::Index>(axis)]);
  }
  EXPECT_EQ(one.radius_m, carve.radius_m);
}

TEST_F(CarveSenderTest, MemoryIsBoundedAndStepsTakeNoHeap) {
  CarveSender small(kSource, 40);
  {
    const AllocationGuard guard;
    while (!small.is_full()) small.note(nth_carve(small.newest() + 1));
    small.accept({.source = kSource, .complete = 0});
    for (int n = 0; n < 1000; ++n) small.take_due(n * kMs);
    if (AllocationGuard::is_available()) {
      EXPECT_EQ(guard.count(), 0U);
    }
  }
  EXPECT_EQ(small.newest(), 40U);
  EXPECT_EQ(small.announce().newest, 40U);
  EXPECT_EQ(small.announce().count, 0U);
}

}  // namespace
}  // namespace hapton
