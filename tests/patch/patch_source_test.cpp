#include "patch/patch_source.h"

#include <gtest/gtest.h>

#include <map>
#include <set>

#include "tests/patch/patch_stage.h"

namespace hapton {
namespace {

constexpr std::int64_t kStartNs = 1'000'000'000;
constexpr std::int64_t kMs = 1'000'000;

// A sheet 100 mm wide whose middle is at the origin, and the source that sends its parts.
struct PatchSourceTest : testing::Test {
  void start(const PatchSource::Options& options, int squares = 40) {
    source = std::make_unique<PatchSource>(make_tiles(scene_of(wavy_sheet(0.05, squares))), 0.001, 7, 5, options);
  }
  // Takes all that is due from from_ns on, for for_ns.
  std::vector<Message> take(std::int64_t from_ns, std::int64_t for_ns = 0) {
    std::vector<Message> taken;
    for (std::int64_t now_ns = from_ns; now_ns <= from_ns + for_ns; now_ns += kMs) {
      while (auto part = source->take(now_ns)) taken.push_back(*part);
    }
    return taken;
  }
  // Takes whatever is in reach, and confirms each part at once.
  std::vector<Message> take_confirmed(double round_trip_s = 0.0) {
    std::vector<Message> taken;
    for (std::int64_t n = 0; n < 1000; ++n) {
      while (auto part = source->take(kStartNs + n * kMs)) taken.push_back(*part);
      source->accept(status_without(static_cast<std::uint32_t>(taken.size()), {}, round_trip_s));
    }
    return taken;
  }
  std::size_t part_count() const { return 1 + source->scene().cells.size() + source->scene().tiles.size(); }
  static std::uint32_t serial_of(const Message& part) {
    if (const auto* tile = std::get_if<PatchTile>(&part)) return tile->serial;
    if (const auto* cell = std::get_if<PatchCell>(&part)) return cell->serial;
    return std::get<PatchBegin>(part).serial;
  }
  double distance_m(const TileCell& cell, const Vec3& p_S) const {
    const PatchGrid& grid = source->scene().grid;
    return grid.step_m * std::sqrt(cell.key.bounds().distance_squared(grid.to_steps(p_S)));
  }
  // The status of a hub that has all parts up to `newest`, except the lost ones.
  static PatchStatus status_without(std::uint32_t newest, const std::set<std::uint32_t>& lost, double round_trip_s = 0.0) {
    PatchStatus status;
    status.epoch = 5;
    status.newest_serial = newest;
    status.round_trip_s = static_cast<float>(round_trip_s);
    for (std::uint32_t back = 0; back < PatchStatus::kSerials && back < newest; ++back) {
      if (!lost.contains(newest - back))
        status.received[back / 8] = static_cast<std::uint8_t>(status.received[back / 8] | (1U << (back % 8)));
    }
    return status;
  }
  static constexpr PatchSource::Options kUnlimited = {.bits_per_s = 1e12, .least_reach_m = 1.0};

  std::unique_ptr<PatchSource> source;
};

TEST_F(PatchSourceTest, TheBeginningComesFirstAndEachCellBeforeItsTiles) {
  start(kUnlimited);
  const auto parts = take(kStartNs, 2000 * kMs);
  ASSERT_GE(parts.size(), part_count());
  const auto* begin = std::get_if<PatchBegin>(&parts.front());
  ASSERT_NE(begin, nullptr);
  EXPECT_EQ(begin->epoch, 5U);
  EXPECT_EQ(begin->scene_hash, 7U);
  EXPECT_EQ(begin->probe_radius_m, 0.001);
  EXPECT_EQ(begin->step_m, source->scene().grid.step_m);
  std::set<std::uint32_t> listed;
  std::uint32_t serial = 0;
  for (std::size_t n = 0; n < part_count(); ++n) {
    EXPECT_EQ(serial_of(parts[n]), ++serial);
    if (const auto* cell = std::get_if<PatchCell>(&parts[n])) {
      EXPECT_EQ(cell->epoch, 5U);
      listed.insert(cell->tiles.begin(), cell->tiles.begin() + cell->tile_count);
    } else if (const auto* tile = std::get_if<PatchTile>(&parts[n])) {
      EXPECT_EQ(tile->epoch, 5U);
      EXPECT_TRUE(listed.contains(tile->tile));
    }
  }
  EXPECT_EQ(listed.size(), source->scene().tiles.size());
}

TEST(HandMotion, ItsVelocityIsAMeanOfATenthOfASecond) {
  HandMotion hand;
  hand.follow(Vec3(0.5, 0.0, 0.0), 0.0);
  EXPECT_EQ(hand.v_SD, Vec3(Vec3::Zero())) << "the first sample";
  hand.follow(Vec3(0.51, 0.0, 0.0), 0.025);
  EXPECT_NEAR(hand.v_SD.x(), 0.25 * 0.4, 1e-12);
  hand.follow(Vec3(0.51, 0.0, 0.0), 0.05);
  EXPECT_NEAR(hand.v_SD.x(), 0.05, 1e-12) << "half of it is the newest";
  hand.follow(Vec3(0.51, 0.08, 0.0), 0.4);
  EXPECT_NEAR(hand.v_SD.x(), 0.0, 1e-12) << "a rare sample says all";
  EXPECT_NEAR(hand.v_SD.y(), 0.2, 1e-12);
  hand.follow(Vec3(0.9, 0.0, 0.0), 1.0);
  hand.follow(Vec3(0.8, 0.0, 0.0), -0.1);
  EXPECT_NEAR(hand.v_SD.y(), 0.2, 1e-12);
  EXPECT_EQ(hand.p_SD, Vec3(0.8, 0.0, 0.0));
}

// Where the hand will be in 0.1 s plus a round trip, and half way there, counts too, but as farther away by half of how far ahead it is.
TEST_F(PatchSourceTest, WhatIsNearestToTheHandAndToItsPathComesFirst) {
  const Vec3 hand(0.01, -0.01, 0.0);
  for (const Vec3& velocity : {Vec3(0, 0, 0), Vec3(0.2, 0, 0), Vec3(-0.1, 0.15, 0)}) {
    SCOPED_TRACE(testing::Message() << velocity.transpose());
    start({.bits_per_s = 1e12, .least_reach_m = 1.0}, 160);
    source->aim({hand, velocity});
    source->accept(status_without(0, {}, 0.1));
    std::map<std::array<std::uint32_t, 4>, double> distances;
    for (const TileCell& cell : source->scene().cells) {
      const Vec3 ahead = 0.2 * velocity;
      const double near = std::min({distance_m(cell, hand), distance_m(cell, hand + 0.5 * ahead) + 0.25 * ahead.norm(),
                                    distance_m(cell, hand + ahead) + 0.5 * ahead.norm()});
      distances[{cell.key.level, cell.key.index[0], cell.key.index[1], cell.key.index[2]}] = near;
    }
    double last_m = 0.0;
    std::size_t cells = 0;
    for (const Message& part : take_confirmed(0.1)) {
      const auto* cell = std::get_if<PatchCell>(&part);
      if (cell == nullptr) continue;
      const double now_m = distances.at({cell->level, cell->index[0], cell->index[1], cell->index[2]});
      EXPECT_GE(now_m, last_m * (1.0 - 1e-6)) << "a round trip is sent as a float";
      last_m = now_m;
      ++cells;
    }
    EXPECT_EQ(cells, source->scene().cells.size());
    EXPECT_GT(last_m, 0.02);
  }
}

// The reach is 10 mm plus the distance that a hand at 50 mm/s covers in twice the sum of 0.1 s and the round trip.
TEST_F(PatchSourceTest, WhatIsOutOfReachIsNotSent) {
  for (const double round_trip_s : {0.0, 0.1, 0.25}) {
    SCOPED_TRACE(testing::Message() << round_trip_s << " s");
    start({.bits_per_s = 1e12, .least_reach_m = 0.01, .fastest_m_per_s = 0.05}, 100);
    const Vec3 hand(-0.04, 0.0, 0.0);
    source->aim({hand, Vec3::Zero()});
    source->accept(status_without(0, {}, round_trip_s));
    const double reach_m = 0.01 + 2.0 * (0.1 + round_trip_s) * 0.05;
    std::size_t expected = 0;
    for (const TileCell& cell : source->scene().cells) expected += distance_m(cell, hand) <= reach_m ? 1 : 0;
    ASSERT_LT(expected, source->scene().cells.size());
    std::set<std::array<std::uint32_t, 3>> sent;
    for (const Message& part : take_confirmed(round_trip_s)) {
      if (const auto* cell = std::get_if<PatchCell>(&part)) sent.insert(cell->index);
    }
    EXPECT_EQ(sent.size(), expected);
  }
}

// The timeout is 150 ms for the hub's status, plus 1.2 round trips. Of a round trip above 0.3 s it is only half, and at most 5 s, because
// a lost part would be missing for too long.
TEST_F(PatchSourceTest, WhatNobodyConfirmsIsSentAgainAfterAWhile) {
  const std::pair<double, std::int64_t> cases[] = {{0.0, 150}, {0.1, 270}, {0.29, 498}, {0.31, 305}, {1.0, 650}, {60.0, 5150}};
  for (const auto& [round_trip_s, timeout_ms] : cases) {
    SCOPED_TRACE(testing::Message() << round_trip_s << " s");
    start({.bits_per_s = 1e12, .least_reach_m = 1.0}, 4);
    source->accept(status_without(0, {}, round_trip_s));
    const auto first = take(kStartNs).size();
    ASSERT_EQ(first, part_count()) << "small enough to be sent at once";
    EXPECT_EQ(take(kStartNs + (timeout_ms - 1) * kMs).size(), 0U);
    EXPECT_EQ(source->counts().repeated, 0U);
    EXPECT_EQ(take(kStartNs + (timeout_ms + 1) * kMs, 20 * kMs).size(), first);
    EXPECT_EQ(source->counts().sent, 2 * first);
    EXPECT_EQ(source->counts().repeated, first);
  }
}

TEST_F(PatchSourceTest, WhatIsConfirmedIsNotSentAgain) {
  start(kUnlimited, 4);
  const auto count = static_cast<std::uint32_t>(take(kStartNs).size());
  source->accept(status_without(count, {2}));
  EXPECT_EQ(source->counts().held, count - 1);
  source->accept(status_without(count, {2}));
  EXPECT_EQ(source->counts().held, count - 1) << "the same status again";
  const auto again = take(kStartNs + 1000 * kMs);
  ASSERT_EQ(again.size(), 1U);
  EXPECT_EQ(serial_of(again[0]), count + 1);
  EXPECT_EQ(source->counts().repeated, 1U);
}

// A part 64 serials before the newest one that arrived is lost; a reordered part would have arrived by then.
TEST_F(PatchSourceTest, WhatIsLostIsSentAgainAtOnce) {
  start(kUnlimited, 80);
  const auto count = static_cast<std::uint32_t>(take(kStartNs, 119 * kMs).size());
  ASSERT_EQ(count, part_count());
  ASSERT_GT(count, 150U);
  source->accept(status_without(count, {count - 10, count - 63, count - 64, count - 70}));
  const auto again = take(kStartNs + 160 * kMs);
  EXPECT_EQ(again.size(), 2U);
  source->accept(status_without(count, {count - 10, count - 63, count - 64, count - 70}));
  EXPECT_EQ(take(kStartNs + 180 * kMs).size(), 0U) << "what was sent again since has another serial";
  EXPECT_EQ(take(kStartNs + 285 * kMs).size(), 2U) << "what may only be late, once its time is over";
}

TEST_F(PatchSourceTest, AStatusOfAnotherEpochOrOfUnsentPartsIsIgnored) {
  start(kUnlimited, 4);
  const auto count = static_cast<std::uint32_t>(take(kStartNs).size());
  PatchStatus other = status_without(count, {});
  other.epoch = 4;
  source->accept(other);
  source->accept(status_without(count + 1, {}));
  EXPECT_EQ(source->counts().held, 0U);
  PatchStatus empty_status;
  source->accept(empty_status);
  EXPECT_EQ(take(kStartNs + 100 * kMs).size(), 0U) << "the hub had nothing yet: what is on its way may still come";
  source->accept(status_without(count, {}));
  EXPECT_EQ(source->counts().held, count);
  source->accept(empty_status);
  EXPECT_EQ(source->counts().held, 0U);
  EXPECT_EQ(take(kStartNs + 120 * kMs).size(), count) << "the hub has started again";
}

// The hub had all parts and has dropped them, and the status that said so was lost. The next one has only a part that was on its way then.
TEST_F(PatchSourceTest, AHubThatHasBegunAgainGetsEverythingEvenIfItsStatusWasLost) {
  start(kUnlimited, 4);
  const auto count = static_cast<std::uint32_t>(take(kStartNs).size());
  source->accept(status_without(count, {2}));
  EXPECT_EQ(source->counts().held, count - 1);
  const auto again = take(kStartNs + 1000 * kMs);
  ASSERT_EQ(again.size(), 1U) << "the second part, again";
  std::set<std::uint32_t> dropped;
  for (std::uint32_t serial = 1; serial <= count; ++serial) dropped.insert(serial);
  source->accept(status_without(count + 1, dropped));
  EXPECT_EQ(source->counts().held, 0U);
  EXPECT_EQ(take(kStartNs + 1020 * kMs).size(), count);
}

// A part was sent twice and came once. The missing second datagram says nothing about the part.
TEST_F(PatchSourceTest, APartThatWasSentTwiceAndCameOnceIsHeld) {
  start(kUnlimited, 4);
  const auto count = static_cast<std::uint32_t>(take(kStartNs).size());
  ASSERT_EQ(take(kStartNs + 1000 * kMs, 20 * kMs).size(), count);
  std::set<std::uint32_t> second_serials;
  for (std::uint32_t serial = count + 1; serial < 2 * count; ++serial) second_serials.insert(serial);
  source->accept(status_without(2 * count, second_serials));
  EXPECT_EQ(source->counts().held, count);
  source->accept(status_without(2 * count, second_serials));
  EXPECT_EQ(source->counts().held, count);
}

TEST_F(PatchSourceTest, ABurstAtFirstAndThenNoMoreThanTheBandwidth) {
  start({.bits_per_s = 8e4, .least_reach_m = 1.0}, 80);
  const std::size_t first = take(kStartNs).size();
  EXPECT_GT(first, 5U);
  EXPECT_LE(source->counts().bytes, 5000U);
  EXPECT_GT(source->counts().bytes, 4000U);
  const auto before = source->counts().bytes;
  (void)take(kStartNs, 1000 * kMs);
  EXPECT_NEAR(static_cast<double>(source->counts().bytes - before), 10'000.0, 900.0) << "in a second";
  // A pause saves up no more than one burst.
  const auto later = source->counts().bytes;
  (void)take(kStartNs + 60'000 * kMs);
  EXPECT_LE(source->counts().bytes - later, 5000U);
  // A part that the budget has no room for does not count as sent: the serials have no gap.
  const auto part = take(kStartNs + 61'000 * kMs);
  ASSERT_FALSE(part.empty());
  EXPECT_EQ(serial_of(part.back()), source->counts().sent);
}

// A part counts as large as its packet: its content plus 150 bytes.
TEST_F(PatchSourceTest, CountsTheBytesOfThePacketOfEachPart) {
  start(kUnlimited, 40);
  std::uint64_t bytes = 0;
  for (const Message& part : take(kStartNs, 100 * kMs)) {
    bytes += 150;
    if (const auto* tile = std::get_if<PatchTile>(&part)) bytes += PatchTile::kVertexBytes * tile->vertex_count + 3 * tile->triangle_count;
    if (const auto* cell = std::get_if<PatchCell>(&part)) bytes += 3 * cell->tile_count;
  }
  EXPECT_EQ(source->counts().bytes, bytes);
}

TEST_F(PatchSourceTest, AnEmptySceneSendsOnlyItsBeginning) {
  source = std::make_unique<PatchSource>(make_tiles(TouchScene()), 0.0, 7, 5, kUnlimited);
  const auto parts = take(kStartNs, 100 * kMs);
  ASSERT_EQ(parts.size(), 1U);
  EXPECT_TRUE(std::holds_alternative<PatchBegin>(parts[0]));
}

TEST_F(PatchSourceTest, AMaterialIsSentWhenItIsAnotherThanTheHubHas) {
  start(kUnlimited);
  (void)take_confirmed();
  const Material of_tiles;
  Material softer = of_tiles;
  softer.stiffness_n_per_m = 300.0;
  auto sent_after = [&, now_ns = kStartNs + 2000 * kMs](const std::vector<Material>& materials) mutable {
    source->set_materials(materials);
    std::vector<double> sent;
    for (const Message& message : take(now_ns += kMs)) {
      EXPECT_EQ(std::get<PatchMaterial>(message).object, 0U);
      sent.push_back(std::get<PatchMaterial>(message).stiffness_n_per_m);
    }
    return sent;
  };
  EXPECT_EQ(sent_after({of_tiles}), std::vector<double>());
  EXPECT_EQ(sent_after({softer, softer}), std::vector{300.0}) << "nothing is sent of an object that has no parts";
  EXPECT_EQ(sent_after({softer}), std::vector<double>()) << "it is on its way";
  EXPECT_EQ(sent_after({}), std::vector<double>());
  EXPECT_EQ(sent_after({of_tiles}), std::vector{of_tiles.stiffness_n_per_m});
}

// The hub still reports the earlier material as received.
TEST_F(PatchSourceTest, AMaterialThatWasLostIsSentAgainThoughTheOneBeforeArrived) {
  start(kUnlimited);
  const auto count = static_cast<std::uint32_t>(take_confirmed().size());
  Material softer;
  softer.stiffness_n_per_m = 300.0;
  source->set_materials({softer});
  ASSERT_EQ(take(kStartNs + 2000 * kMs).size(), 1U);
  source->accept(status_without(count + 1, {}));
  Material softest;
  softest.stiffness_n_per_m = 100.0;
  source->set_materials({softest});
  ASSERT_EQ(take(kStartNs + 2001 * kMs).size(), 1U) << "which is lost";
  source->accept(status_without(count + 1, {}));
  const auto again = take(kStartNs + 2002 * kMs, 500 * kMs);
  ASSERT_FALSE(again.empty());
  EXPECT_EQ(std::get<PatchMaterial>(again.front()).stiffness_n_per_m, 100.0);
}

// With a long round trip a material is sent again before its first datagram can be confirmed.
TEST_F(PatchSourceTest, AMaterialIsConfirmedByAnyOfTheTimesThatItWasSent) {
  start(kUnlimited);
  const auto count = static_cast<std::uint32_t>(take_confirmed().size());
  Material softer;
  softer.stiffness_n_per_m = 300.0;
  source->set_materials({softer});
  const auto sent = take(kStartNs + 2000 * kMs, 500 * kMs);
  ASSERT_GT(sent.size(), 2U) << "nobody confirms";
  source->accept(status_without(count + 1, {}));
  EXPECT_TRUE(take(kStartNs + 3000 * kMs, 500 * kMs).empty());
}

// A move is sent again 70 ms plus a round trip later, eight times at most, as the hub confirms only the last moves of all objects.
TEST_F(PatchSourceTest, AMoveIsSentAgainUntilItIsConfirmed) {
  start(kUnlimited, 4);
  (void)take_confirmed();
  const auto count = static_cast<std::uint32_t>(source->counts().sent);
  const auto confirm = [&](std::uint32_t newest_move, std::uint64_t moves) {
    PatchStatus status = status_without(count, {}, 0.03);
    status.newest_move = newest_move;
    status.moves_received = moves;
    source->accept(status);
  };
  // The objects of the moves that are sent at this time.
  const auto moves_at = [&](std::int64_t ms) {
    std::vector<std::int32_t> objects;
    for (const Message& message : take(kStartNs + ms * kMs)) {
      const auto* move = std::get_if<ObjectMove>(&message);
      EXPECT_NE(move, nullptr) << "all else is there";
      if (move != nullptr) objects.push_back(move->object);
    }
    return objects;
  };
  confirm(0, 0);
  source->note_move({.source = 9, .serial = 4, .object = 2}, kStartNs + 2000 * kMs);
  source->note_move({.source = 9, .serial = 5, .object = 3}, kStartNs + 2000 * kMs);
  source->note_move({.source = 9, .serial = 3, .object = 2}, kStartNs + 1000 * kMs);  // overtaken by 4
  EXPECT_TRUE(moves_at(2099).empty());
  EXPECT_EQ(moves_at(2101), (std::vector<std::int32_t>{2, 3}));
  EXPECT_EQ(source->counts().moves_repeated, 2U);
  confirm(6, 0b101);  // 6 and 4, but not 5
  EXPECT_EQ(moves_at(2300), std::vector<std::int32_t>{3});
  confirm(6, 0b111);
  EXPECT_TRUE(moves_at(2600).empty());
  confirm(0, 0);
  EXPECT_EQ(source->counts().moves_repeated, 3U);
  EXPECT_EQ(moves_at(2601), (std::vector<std::int32_t>{2, 3})) << "the hub has started again";
  EXPECT_EQ(source->counts().moves_repeated, 3U) << "it was not sent them before";
  std::size_t sent = 2;
  for (std::int64_t ms = 2800; ms < 6000; ms += 200) sent += moves_at(ms).size();
  EXPECT_EQ(sent, 2U * 8U);
}

// A move takes more bytes than some parts. When the bandwidth is used up, they could all go before it, one after the other.
TEST_F(PatchSourceTest, AMoveThatIsDueGoesBeforeSmallerParts) {
  TouchScene scene;
  for (int n = 0; n < 40; ++n) scene.objects.push_back({made::shared(made::sheet(0.01, 0.0, 1)), {}});
  source = std::make_unique<PatchSource>(make_tiles(scene), 0.0, 7, 5, PatchSource::Options{.bits_per_s = 8e4, .least_reach_m = 1.0});
  (void)take_confirmed();
  ASSERT_EQ(source->counts().held, part_count());
  source->set_materials(std::vector<Material>(40, {.stiffness_n_per_m = 300.0}));
  const std::size_t burst = take(kStartNs + 3000 * kMs).size();
  ASSERT_EQ(burst, 33U) << "5,000 bytes, in parts of 150 bytes";
  source->note_move({.source = 9, .serial = 4, .object = 2}, -1);
  const auto next = take(kStartNs + 3000 * kMs, 50 * kMs);
  ASSERT_EQ(next.size(), 2U) << "500 bytes in 50 ms, and the 50 that the burst left";
  EXPECT_TRUE(std::holds_alternative<ObjectMove>(next[0]));
  EXPECT_TRUE(std::holds_alternative<PatchMaterial>(next[1]));
  EXPECT_EQ(source->counts().moves_repeated, 0U) << "the caller has not sent it";
}

TEST_F(PatchSourceTest, SaysWhatItRepliesTo) {
  start(kUnlimited, 4);
  source->reply_to(17, 23);
  const auto parts = take(kStartNs);
  ASSERT_FALSE(parts.empty());
  EXPECT_EQ(std::get<PatchBegin>(parts[0]).request, 17U);
  EXPECT_EQ(std::get<PatchBegin>(parts[0]).method_serial, 23U);
}

// The hub must not let the surface be felt in a shape that is older than the noted one.
TEST_F(PatchSourceTest, AnObjectThatProgramsDeformHasTheNewestShapeThatWasNoted) {
  TouchScene scene = scene_of(made::sheet(0.02, 0.0, 2));
  for (int n = 1; n <= 2; ++n) {
    scene.objects.push_back({made::shared(made::sheet(0.01, 0.01 * n, 2)), {}});
    scene.objects.back().stream_reach_m = 0.001;
  }
  source = std::make_unique<PatchSource>(make_tiles(scene), 0.0, 7, 5, kUnlimited);
  source->note_shape(1, 6);
  source->note_shape(1, 4);  // overtaken by 6
  std::map<std::int32_t, std::set<std::uint32_t>> serials;
  for (const Message& part : take(kStartNs, 100 * kMs)) {
    if (const auto* stream = std::get_if<PatchStream>(&part)) serials[stream->object].insert(stream->shape_serial);
  }
  EXPECT_EQ(serials, (std::map<std::int32_t, std::set<std::uint32_t>>{{1, {6}}, {2, {0}}}));
}

}  // namespace
}  // namespace hapton
