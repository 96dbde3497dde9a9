#include "link/known_carves.h"

#include <gtest/gtest.h>

#include <vector>

namespace hapton {
namespace {

// Each carve has its serial as its object, so that the tests can tell carves apart.
Carves make_carves(std::uint32_t source, std::uint32_t first, std::uint32_t count, std::uint32_t newest) {
  Carves carves{.source = source, .newest = newest, .first = count > 0 ? first : 0, .count = count};
  for (std::uint32_t n = 0; n < count; ++n) carves.carves[n] = {.object = static_cast<std::int32_t>(first + n), .radius_m = 0.01F};
  return carves;
}

std::vector<std::int32_t> objects_of(const KnownCarves::News& news) {
  std::vector<std::int32_t> objects;
  for (const Carves::One& one : news.carves) objects.push_back(one.object);
  return objects;
}

using Objects = std::vector<std::int32_t>;

TEST(KnownCarves, WhatIsNewIsAppliedOnce) {
  KnownCarves known;
  const Carves first = make_carves(5, 1, 3, 3);
  const KnownCarves::News news = known.take(first, Arrival::newest);
  EXPECT_TRUE(news.starts_anew) << "the first of a process";
  EXPECT_EQ(objects_of(news), (Objects{1, 2, 3}));
  const Carves overlapping = make_carves(5, 2, 4, 5);
  EXPECT_EQ(objects_of(known.take(overlapping, Arrival::newest)), (Objects{4, 5}));
  EXPECT_FALSE(known.take(overlapping, Arrival::newest).starts_anew);
  EXPECT_EQ(objects_of(known.take(overlapping, Arrival::reordered)), Objects());
  EXPECT_EQ(known.complete(), 5U);
  EXPECT_FALSE(known.take_request(0)) << "nothing is missing";
}

TEST(KnownCarves, WhatIsMissingIsRequestedTenTimesASecond) {
  KnownCarves known;
  const Carves first = make_carves(5, 1, 2, 2);
  known.take(first, Arrival::newest);
  const Carves later = make_carves(5, 6, 2, 9);
  EXPECT_EQ(objects_of(known.take(later, Arrival::newest)), (Objects{6, 7})) << "seen at once, although others are missing";
  EXPECT_EQ(known.complete(), 2U);
  EXPECT_EQ(known.newest(), 9U);
  const auto request = known.take_request(1'000'000'000);
  ASSERT_TRUE(request);
  EXPECT_EQ(request->source, 5U);
  EXPECT_EQ(request->complete, 2U);
  EXPECT_FALSE(known.take_request(1'099'999'999));
  EXPECT_TRUE(known.take_request(1'100'000'000));
  const Carves missing = make_carves(5, 3, 7, 9);
  EXPECT_EQ(objects_of(known.take(missing, Arrival::newest)), (Objects{3, 4, 5, 6, 7, 8, 9}));
  EXPECT_FALSE(known.take_request(2'000'000'000));
}

TEST(KnownCarves, WhoJoinsLateRequestsAll) {
  KnownCarves known;
  known.take(make_carves(5, 0, 0, 700), Arrival::newest);
  const auto request = known.take_request(0);
  ASSERT_TRUE(request);
  EXPECT_EQ(request->complete, 0U);
}

TEST(KnownCarves, AnotherProcessBeginsWithWholeObjects) {
  KnownCarves known;
  const Carves first = make_carves(5, 1, 3, 3);
  known.take(first, Arrival::newest);
  EXPECT_TRUE(known.take(make_carves(6, 0, 0, 0), Arrival::newest).starts_anew) << "also without carves";
  EXPECT_EQ(known.complete(), 0U);
  EXPECT_EQ(known.newest(), 0U);
  const KnownCarves::News late = known.take(first, Arrival::reordered);
  EXPECT_FALSE(late.starts_anew) << "of the process before";
  EXPECT_TRUE(late.carves.empty());
  EXPECT_FALSE(known.take_request(0));
}

TEST(KnownCarves, TheLargestSerialsCount) {
  KnownCarves known;
  const Carves last = make_carves(5, 0xFFFFFFF0, 16, 0xFFFFFFFF);
  EXPECT_EQ(known.take(last, Arrival::newest).carves.size(), 16U);
  EXPECT_EQ(known.complete(), 0U);
  EXPECT_TRUE(known.take_request(0));
}

}  // namespace
}  // namespace hapton
