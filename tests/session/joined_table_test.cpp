#include "session/joined_table.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "tests/session/made_entries.h"

namespace hapton {
namespace {

struct Joined {
  std::vector<JoinedRow> rows;
  JoinedTable table{kJoinedStartNs, [this](const JoinedRow& row) { rows.push_back(row); }};

  void force(std::uint64_t sample, std::int64_t time_ns) {
    const auto [entry, datagram] = arrival_of(force_of(sample), time_ns);
    table.add(entry, &datagram);
  }
};

TEST(JoinedTable, AForceStandsBesideItsSampleWheneverItCame) {
  Joined joined;
  joined.force(1, sample_ns(1) + 100'000);  // before the cycle is recorded, as on a fast network
  joined.table.add(cycle_of(1), nullptr);
  joined.table.add(cycle_of(2), nullptr);
  joined.table.add(cycle_of(3), nullptr);
  joined.force(3, sample_ns(3) + 300'000);
  joined.force(2, sample_ns(3) + 400'000);  // overtaken
  joined.table.finish();
  ASSERT_EQ(joined.rows.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    const JoinedRow& row = joined.rows[i];
    EXPECT_EQ(row.sample, i + 1);
    EXPECT_EQ(row.wanted_n.z(), static_cast<double>(i + 1));
    EXPECT_DOUBLE_EQ(row.p_WP.z(), 0.201);
    EXPECT_TRUE(row.is_contact);
    EXPECT_EQ(row.object, 1);
    EXPECT_FALSE(row.is_local);
    EXPECT_EQ(row.buttons, 5U);
  }
  EXPECT_NEAR(joined.rows[0].sample_t_s, 1e-3, 1e-12);
  EXPECT_NEAR(joined.rows[1].v_WD.x(), 0.1, 1e-9);
  EXPECT_NEAR(joined.rows[1].round_trip_s, 1.4e-3, 1e-12);
  EXPECT_EQ(joined.rows[2].missed, 2U);
}

TEST(JoinedTable, ARowWhoseForceNeverComesIsThereWithoutOne) {
  Joined joined;
  joined.table.add(cycle_of(1), nullptr);
  joined.table.add(cycle_of(2), nullptr);
  joined.force(2, sample_ns(2) + 300'000);
  EXPECT_TRUE(joined.rows.empty()) << "in the order of the samples";
  joined.table.add(cycle_of(6000), nullptr);
  ASSERT_EQ(joined.rows.size(), 2U);
  EXPECT_TRUE(std::isnan(joined.rows[0].wanted_n.x()));
  EXPECT_TRUE(std::isnan(joined.rows[0].round_trip_s));
  EXPECT_FALSE(joined.rows[0].is_contact);
  joined.table.finish();
  EXPECT_EQ(joined.rows.size(), 3U);
}

TEST(JoinedTable, LocalForcesEventsAndOlderRecordings) {
  Joined joined;
  SessionEntry fault;
  fault.kind = SessionEntry::Kind::fault;
  fault.fault = SessionFault::clamped;
  joined.table.add(fault, nullptr);
  fault.fault = SessionFault::speed;
  joined.table.add(fault, nullptr);
  SessionEntry local = cycle_of(1);
  local.cycle.local = CycleLocal{Vec3(0.0, 2.0, 0.0), Vec3(0.0, 1e-3, 0.0), 6};
  joined.table.add(local, nullptr);
  SessionEntry old = cycle_of(2);
  old.cycle.device.reset();
  joined.table.add(old, nullptr);
  joined.table.finish();
  ASSERT_EQ(joined.rows.size(), 1U);
  EXPECT_EQ(joined.rows[0].event, "clamped speed");
  EXPECT_TRUE(joined.rows[0].is_local);
  EXPECT_EQ(joined.rows[0].object, 6);
  EXPECT_TRUE(joined.rows[0].is_contact);
  EXPECT_EQ(joined.rows[0].wanted_n.y(), 2.0);
  EXPECT_DOUBLE_EQ(joined.rows[0].p_WP.y(), 1e-3);
  EXPECT_EQ(joined.table.without_sample(), 1U);
}

TEST(JoinedTable, AGapIsNamedAndCounted) {
  Joined joined;
  for (const std::uint64_t sample : {40U, 41U, 157U, 158U, 158U, 160U}) joined.table.add(cycle_of(sample), nullptr);
  joined.table.finish();
  std::vector<std::uint64_t> lost;
  for (const JoinedRow& row : joined.rows) lost.push_back(row.lost);
  EXPECT_EQ(lost, (std::vector<std::uint64_t>{0, 0, 115, 0, 0, 1})) << "what was before a flight record is no gap";
  EXPECT_EQ(joined.table.lost(), 116U);
  EXPECT_EQ(joined.table.gaps(), 2U);
}

TEST(JoinedTable, AMarkerStandsAtItsSample) {
  Joined joined;
  joined.table.add(marker_of(1, "begin"), nullptr);  // within the cycle, as usual
  joined.table.add(cycle_of(1), nullptr);
  joined.force(1, sample_ns(1) + 250'000);
  joined.table.add(marker_of(1, "after its force"), nullptr);
  joined.table.add(marker_of(2, "of a lost row"), nullptr);
  joined.table.add(cycle_of(4), nullptr);
  joined.table.add(marker_of(5, "at the end"), nullptr);
  joined.table.finish();
  ASSERT_EQ(joined.rows.size(), 2U);
  EXPECT_EQ(joined.rows[0].markers, (std::vector<std::string>{"begin", "after its force"}));
  EXPECT_EQ(joined.rows[1].markers, (std::vector<std::string>{"of a lost row", "at the end"}));
  Joined empty;
  empty.table.add(marker_of(5, "without a row"), nullptr);
  empty.table.finish();
  EXPECT_TRUE(empty.rows.empty());
}

// As `--overrun stop` ends a session: the fault is the last entry.
TEST(JoinedTable, AFaultBehindTheLastCycleIsNotLost) {
  Joined joined;
  SessionEntry local = cycle_of(1);
  local.cycle.local = CycleLocal{};
  joined.table.add(local, nullptr);
  SessionEntry fault;
  fault.kind = SessionEntry::Kind::fault;
  fault.fault = SessionFault::overrun;
  joined.table.add(fault, nullptr);
  joined.table.finish();
  ASSERT_EQ(joined.rows.size(), 1U);
  EXPECT_EQ(joined.rows[0].event, "overrun");
}

TEST(JoinedTable, TimesOfAHostileFileDoNoHarm) {
  Joined joined;
  for (const std::int64_t time_ns :
       {std::numeric_limits<std::int64_t>::min(), std::int64_t{-1}, std::numeric_limits<std::int64_t>::max()}) {
    SessionEntry entry = cycle_of(1);
    entry.time_ns = time_ns;
    entry.cycle.device->time_ns = -time_ns / 2;
    joined.table.add(entry, nullptr);
  }
  joined.table.finish();
  EXPECT_EQ(joined.rows.size(), 3U);
}

}  // namespace
}  // namespace hapton
